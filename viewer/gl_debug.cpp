#include "foreview/viewer/gl_debug.h"

#include <cstdlib>
#include <string>

#include "foreview/scene/errors.h"

namespace foreview {

GlDebug gl_debug_from_environment() {
  const char* value = std::getenv("FOREVIEW_GL_DEBUG");
  const std::string text = value != nullptr ? value : "";
  if (text.empty()) return GlDebug::off;
  if (text == "log") return GlDebug::log;
  if (text == "fatal") return GlDebug::fatal;
  throw InputError("FOREVIEW_GL_DEBUG", "\"" + text + "\" is not known; expected \"log\" or \"fatal\"");
}

}  // namespace foreview
