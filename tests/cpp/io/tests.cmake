raylign_add_test(io byte_stream_test.cpp)
raylign_add_test(io text_scanner_test.cpp)
raylign_add_test(io bal_test.cpp)
raylign_add_test(io ply_test.cpp)
