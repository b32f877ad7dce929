raylign_add_test(patch pattern_test.cpp)
raylign_add_test(patch patch_image_test.cpp)
raylign_add_test(patch patch_scene_test.cpp)
