raylign_add_test(robust loss_test.cpp LINK Ceres::ceres)
