#include "foreview/gpu/offscreen_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "foreview/scene/errors.h"

namespace foreview {

struct OffscreenContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  EGLSurface surface = EGL_NO_SURFACE;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (context != EGL_NO_CONTEXT) {
      eglBindAPI(EGL_OPENGL_API);
      if (eglGetCurrentContext() == context) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
      eglDestroyContext(display, context);
    }
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
  }
};

namespace {

constexpr int kMajor = 4, kMinor = 5;

std::string egl_error() {
  char text[32];
  std::snprintf(text, sizeof text, "EGL error 0x%04X", static_cast<unsigned>(eglGetError()));
  return text;
}

bool has_extension(const char* list, std::string_view name) {
  if (list == nullptr) return false;
  std::string_view rest(list);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// A display to try, and how to name it in a message.
struct Candidate {
  EGLDisplay display = EGL_NO_DISPLAY;
  std::string name;
};

/// Devices in EGL's order, but software ones last.
void add_devices(std::vector<Candidate>& candidates, std::vector<std::string>& failures) {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool enumeration =
      has_extension(extensions, "EGL_EXT_device_base") ||
      (has_extension(extensions, "EGL_EXT_device_enumeration") && has_extension(extensions, "EGL_EXT_device_query"));
  if (!enumeration || !has_extension(extensions, "EGL_EXT_platform_device")) {
    failures.emplace_back("EGL has no device platform");
    return;
  }
  EGLint count = 0;
  if (eglQueryDevicesEXT(0, nullptr, &count) == EGL_FALSE || count <= 0) {
    failures.emplace_back("EGL knows no device");
    return;
  }
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  eglQueryDevicesEXT(count, devices.data(), &count);
  devices.resize(static_cast<std::size_t>(count));

  std::size_t first = 0, last = devices.size();
  if (const char* wanted = std::getenv("FOREVIEW_EGL_DEVICE"); wanted != nullptr && *wanted != '\0') {
    const char* end = wanted + std::strlen(wanted);
    const auto [parsed_to, error] = std::from_chars(wanted, end, first);
    if (error != std::errc() || parsed_to != end || first >= devices.size()) {
      throw InputError("FOREVIEW_EGL_DEVICE", "'" + std::string(wanted) + "' is no EGL device; expected 0 to " +
                                                  std::to_string(devices.size() - 1));
    }
    last = first + 1;
  }
  for (const bool software : {false, true}) {
    for (std::size_t i = first; i < last; ++i) {
      const char* device_extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
      if (has_extension(device_extensions, "EGL_MESA_device_software") != software) continue;
      candidates.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr),
                            "device " + std::to_string(i) + (software ? " (software)" : "")});
    }
  }
}

std::vector<Candidate> candidate_displays(std::vector<std::string>& failures) {
  std::vector<Candidate> candidates;
  add_devices(candidates, failures);
  if (std::getenv("FOREVIEW_EGL_DEVICE") != nullptr && !candidates.empty()) return candidates;
  if (has_extension(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless")) {
    candidates.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr), "surfaceless"});
  }
  candidates.push_back({eglGetDisplay(EGL_DEFAULT_DISPLAY), "default display"});
  return candidates;
}

/// Makes the context current on success. Returns what went wrong, or nothing.
std::string try_display(EGLDisplay display, const OffscreenContext::Options& options, EGLContext& context,
                        EGLSurface& surface) {
  if (display == EGL_NO_DISPLAY) return "no display";
  EGLint major = 0, minor = 0;
  if (eglInitialize(display, &major, &minor) == EGL_FALSE) return "cannot be initialised, " + egl_error();
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return "has no OpenGL, " + egl_error();
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  const bool needs_surface = !has_extension(extensions, "EGL_KHR_surfaceless_context");

  EGLConfig config = nullptr;
  EGLint found = 0;
  // Where no surface is needed, a config without any surface type serves too.
  for (const EGLint surface_type : {EGL_PBUFFER_BIT, 0}) {
    const EGLint wanted[] = {EGL_SURFACE_TYPE, surface_type, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    if (eglChooseConfig(display, wanted, &config, 1, &found) == EGL_TRUE && found > 0) break;
    if (needs_surface) break;
  }
  if (found <= 0) return "offers no config for OpenGL";

  const EGLContext shared = options.share_context == nullptr ? EGL_NO_CONTEXT : options.share_context;
  // Told of resets where the driver can tell. Of contexts that share objects all must be, or none.
  for (const EGLint strategy : {EGL_LOSE_CONTEXT_ON_RESET, EGL_NO_RESET_NOTIFICATION}) {
    const bool told = strategy == EGL_LOSE_CONTEXT_ON_RESET;
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 kMajor,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 kMinor,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 options.debug ? EGL_TRUE : EGL_FALSE,
                                 told ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
                                 strategy,
                                 EGL_NONE};
    context = eglCreateContext(display, config, shared, attributes);
    if (context != EGL_NO_CONTEXT) break;
  }
  if (context == EGL_NO_CONTEXT) return "gives no OpenGL 4.5 core context, " + egl_error();
  if (needs_surface) {
    const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface = eglCreatePbufferSurface(display, config, size);
  }
  if ((needs_surface && surface == EGL_NO_SURFACE) || eglMakeCurrent(display, surface, surface, context) == EGL_FALSE) {
    const std::string error = egl_error();
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    eglDestroyContext(display, context);
    surface = EGL_NO_SURFACE;
    context = EGL_NO_CONTEXT;
    return "its context cannot be made current, " + error;
  }
  return {};
}

}  // namespace

OffscreenContext::OffscreenContext() : OffscreenContext(Options{}) {}

OffscreenContext::OffscreenContext(const Options& options) : state_(std::make_unique<State>()) {
  std::vector<std::string> failures;
  const std::vector<Candidate> candidates = options.share_display != nullptr
                                                ? std::vector<Candidate>{{options.share_display, "the shared display"}}
                                                : candidate_displays(failures);
  for (const Candidate& candidate : candidates) {
    const std::string failure = try_display(candidate.display, options, state_->context, state_->surface);
    if (failure.empty()) {
      state_->display = candidate.display;
      break;
    }
    failures.push_back(candidate.name + ": " + failure);
  }
  if (state_->context == EGL_NO_CONTEXT) {
    std::string text = "no off-screen OpenGL 4.5 context can be made:";
    for (const std::string& failure : failures) text += " " + failure + ";";
    throw GraphicsError(text + " is a driver (or Mesa's libegl-mesa0 and libgl1-mesa-dri) installed?");
  }
  if (options.debug) install_debug_callback(false);
  set_up_context_state();
}

OffscreenContext::~OffscreenContext() = default;

void OffscreenContext::make_current() {
  // The bound API is a property of the thread.
  eglBindAPI(EGL_OPENGL_API);
  if (eglMakeCurrent(state_->display, state_->surface, state_->surface, state_->context) == EGL_FALSE) {
    throw GraphicsError("the off-screen OpenGL context cannot be made current, " + egl_error());
  }
}

void OffscreenContext::release_current() {
  eglBindAPI(EGL_OPENGL_API);
  eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

std::string OffscreenContext::renderer() const {
  const auto text = [](GLenum name) { return std::string(reinterpret_cast<const char*>(glGetString(name))); };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

void* OffscreenContext::display() const {
  return state_->display;
}

void* OffscreenContext::context() const {
  return state_->context;
}

void set_up_context_state() {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  glClearDepth(0.0);
  glFrontFace(GL_CW);
  glDisable(GL_DITHER);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
}

}  // namespace foreview
