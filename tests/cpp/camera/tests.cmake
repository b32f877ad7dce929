raylign_add_test(camera cameras_test.cpp LINK Ceres::ceres)
raylign_add_test(camera distortion_test.cpp)
