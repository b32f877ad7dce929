raylign_add_test(solver options_test.cpp)
