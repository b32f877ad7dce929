raylign_add_test(geometry groups_test.cpp)
raylign_add_test(geometry so3_test.cpp)
raylign_add_test(geometry umeyama_test.cpp)
