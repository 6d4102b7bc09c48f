#pragma once
#include <memory>
#include <string>

namespace foreview {

/// An OpenGL 4.5 core context without a window: EGL on the device platform, else Mesa's surfaceless platform, else the
/// default display; with a 1x1 pbuffer surface where the driver cannot go without. GraphicsError explains a failure.
class OffscreenContext {
 public:
  struct Options {
    bool debug = false;             ///< debug context whose callback throws away nothing: see install_debug_callback()
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

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Routes GL debug messages of the current context: errors and undefined behaviour are logged, and with `fatal` abort
/// the process (tests). Severity below medium is dropped.
void install_debug_callback(bool fatal);
/// The state every foreview context starts from: clip control (upper left is row 0, depth 0..1), no dithering, tight
/// pixel storage. Called by OffscreenContext; a window's context needs it once.
void set_up_context_state();

}  // namespace foreview
