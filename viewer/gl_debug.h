#pragma once

namespace foreview {

/// What the environment variable FOREVIEW_GL_DEBUG asks of every OpenGL context that the executable makes:
/// unset or empty: nothing; "log": a debug context whose errors are logged; "fatal": a debug context in which the
/// first error ends the process (tests). Anything else throws InputError.
enum class GlDebug { off, log, fatal };
[[nodiscard]] GlDebug gl_debug_from_environment();

}  // namespace foreview
