#pragma once
#include <memory>
#include <string>

namespace foreview {

/// An OpenGL 4.5 core context without a window: EGL on the device platform, else Mesa's surfaceless platform, else the
/// default display; with a 1x1 pbuffer surface where the driver cannot go without. GraphicsError explains a failure.
/// Of several devices the first that gives a context is taken, hardware before software; the environment variable
/// FOREVIEW_EGL_DEVICE (0, 1, ... in EGL's order) picks one. Where the driver offers it, a reset of the GPU is told by
/// glGetGraphicsResetStatus(). The context is current, and in the state of
/// set_up_context_state(), when the constructor returns. EGL displays stay initialised until the process ends, because
/// contexts share them.
class OffscreenContext {
 public:
  struct Options {
    bool debug = false;             ///< a debug context, with install_debug_callback(false)
    void* share_display = nullptr;  ///< EGLDisplay of a window's context (GLFW's), to share objects with it
    void* share_context = nullptr;  ///< EGLContext to share objects with
  };
  OffscreenContext();
  explicit OffscreenContext(const Options& options);
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
  void make_current();
  void release_current();
  [[nodiscard]] std::string renderer() const;  ///< GL_RENDERER and GL_VERSION, one line
  [[nodiscard]] void* display() const;         ///< EGLDisplay, for Options::share_display of another context
  [[nodiscard]] void* context() const;         ///< EGLContext, for Options::share_context

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Routes GL debug messages of the current context: errors and undefined behaviour are logged, and with `fatal` abort
/// the process (tests). Severity below medium is dropped, and so is the shader compiler's, which make_program() throws.
void install_debug_callback(bool fatal);
/// The state every foreview context starts from, in the conventions of CameraModel::clip_from_camera(): clip control
/// (lower left, depth 0..1), reversed depth (GL_GREATER, cleared to 0; the test itself is off), no dithering, tight
/// pixel storage. As pictures lie with their top in row 0, what is counter-clockwise on the picture is clockwise in
/// window coordinates: so front faces are GL_CW. Where a polygon's plane is at hand, cull by its sign instead.
/// Called by OffscreenContext; a window's context needs it once.
void set_up_context_state();

}  // namespace foreview
