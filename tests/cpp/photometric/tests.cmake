raylign_add_test(photometric noise_law_test.cpp)
raylign_add_test(photometric patch_problem_test.cpp)
raylign_add_test(photometric covariance_test.cpp)
raylign_add_test(photometric parity_test.cpp)
