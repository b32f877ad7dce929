raylign_add_test(bundle allocation_test.cpp)
raylign_add_test(bundle camera_blocks_test.cpp)
raylign_add_test(bundle kernels_test.cpp)
raylign_add_test(bundle native_test.cpp LINK raylign_io)
