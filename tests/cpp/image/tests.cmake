raylign_add_test(image remap_test.cpp)
