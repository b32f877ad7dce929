raylign_add_test(depth inverse_depth_test.cpp)
