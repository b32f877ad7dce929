raylign_add_test(scene bal_problem_test.cpp)
raylign_add_test(scene bal_statistics_test.cpp)
raylign_add_test(scene bal_transform_test.cpp)
raylign_add_test(scene bundle_problem_test.cpp LINK raylign_solver)
