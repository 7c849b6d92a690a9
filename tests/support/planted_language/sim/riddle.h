// Of a planted fault for the language test.
inline constexpr const char* kForm = "nobody knows the pose";
inline constexpr const char* kWord = "the believed pose";
inline constexpr int kPartCount = 1;
