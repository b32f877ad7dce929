raylign_add_test(tracking kernels_test.cpp)
