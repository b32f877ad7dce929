raylign_add_test(tracking aligner_test.cpp)
raylign_add_test(tracking kernels_test.cpp)
raylign_add_test(tracking shutter_test.cpp)
raylign_add_test(tracking statistics_test.cpp LABELS slow)
