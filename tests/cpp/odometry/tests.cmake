raylign_add_test(odometry odometry_test.cpp)
