#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <string>

#include "foreview/gpu/offscreen_context.h"

namespace foreview {

namespace {

void GLAPIENTRY on_debug_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                 const GLchar* text, const void* user) {
  if (severity != GL_DEBUG_SEVERITY_HIGH && severity != GL_DEBUG_SEVERITY_MEDIUM) return;
  // make_program() reports these itself, with the source; as an exception they are no reason to abort.
  if (source == GL_DEBUG_SOURCE_SHADER_COMPILER) return;
  const std::string message = length < 0 ? std::string(text) : std::string(text, static_cast<std::size_t>(length));
  if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) {
    spdlog::debug("OpenGL message {}: {}", id, message);
    return;
  }
  spdlog::error("OpenGL error {}: {}", id, message);
  if (user != nullptr) {
    spdlog::default_logger()->flush();
    std::abort();
  }
}

}  // namespace

void install_debug_callback(bool fatal) {
  static const char fatal_mark = 0;
  glEnable(GL_DEBUG_OUTPUT);
  // Synchronous, so that the abort's stack shows the call that is wrong.
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(on_debug_message, fatal ? &fatal_mark : nullptr);
}

}  // namespace foreview
