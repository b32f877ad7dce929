raylign_add_test(synthetic bal_test.cpp LINK raylign_io)
raylign_add_test(synthetic bal_options_test.cpp)
raylign_add_test(synthetic street_route_test.cpp)
raylign_add_test(synthetic camera_neighbors_test.cpp)
