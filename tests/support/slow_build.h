#pragma once

namespace foreview::test {

/// ThreadSanitizer: software rendering takes many times as long. Tests in real time then allow for it where they must;
/// what they say of races is unharmed.
#ifdef __SANITIZE_THREAD__
inline constexpr bool kIsSlowBuild = true;
#else
inline constexpr bool kIsSlowBuild = false;
#endif

}  // namespace foreview::test
