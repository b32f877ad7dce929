raylign_add_test(solver options_test.cpp)
raylign_add_test(solver lm_test.cpp)
raylign_add_test(solver blocked_cholesky_test.cpp)
