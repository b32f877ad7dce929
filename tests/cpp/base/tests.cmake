raylign_add_test(base random_test.cpp)
raylign_add_test(base portable_math_test.cpp)
raylign_add_test(base table_memory_test.cpp)
