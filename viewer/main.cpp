#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/errors.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"

namespace {

enum ExitStatus { kSuccess = 0, kInputError = 2, kGraphicsError = 3, kInternalError = 4, kInterrupted = 130 };

int fail(ExitStatus status, const std::string& message) {
  std::fprintf(stderr, "foreview: %s\n", message.c_str());
  return status;
}

struct GlobalOptions {
  bool quiet = false;
  bool verbose = false;
  std::string shader_directory;
};

void apply(const GlobalOptions& options) {
  foreview::ProgressBar::set_quiet(options.quiet);
  spdlog::set_level(options.quiet ? spdlog::level::err : options.verbose ? spdlog::level::debug : spdlog::level::info);
  if (!options.shader_directory.empty()) foreview::set_shader_directory(options.shader_directory.c_str());
}

/// The subcommand that the user was typing, for the hint after a mistake.
std::string command_path(const CLI::App& app) {
  const auto used = app.get_subcommands();
  return used.empty() ? app.get_name() : app.get_name() + " " + used.front()->get_name();
}

int run(int argc, char** argv) {
  CLI::App app{"A photorealistic predictive display for telepresence.", "foreview"};
  GlobalOptions options;
  app.fallthrough();  // so that the global options may follow the subcommand
  app.require_subcommand(1);
  auto* quiet = app.add_flag("--quiet", options.quiet, "No progress bars; only errors are logged");
  app.add_flag("--verbose", options.verbose, "Log more")->excludes(quiet);
  app.add_option("--shader-dir", options.shader_directory,
                 "Read shaders from this directory instead of the built-in ones")
      ->type_name("DIR");
  app.set_version_flag("--version", std::string("foreview ") + FOREVIEW_VERSION);
  app.footer("Every subcommand has its own help: foreview view --help\nExample: foreview view workcell");
  app.parse_complete_callback([&] { apply(options); });

  // One line each: the subcommands.
  foreview::add_inspect_command(app);
  foreview::add_generate_command(app);
  foreview::add_view_command(app);
  foreview::add_replay_command(app);
  foreview::add_evaluate_command(app);
  foreview::add_export_command(app);
  foreview::add_bench_command(app);
  foreview::add_send_command(app);
  foreview::add_serve_command(app);
  foreview::add_record_command(app);

  try {
    app.parse(argc, argv);
    return kSuccess;
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    return fail(kInputError, std::string(error.what()) + " (see " + command_path(app) + " --help)");
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("foreview"));
    spdlog::set_pattern("%^%l%$: %v");
    foreview::install_interrupt_handler();
    return run(argc, argv);
  } catch (const foreview::InputError& error) {
    return fail(kInputError, error.what());
  } catch (const foreview::GraphicsError& error) {
    return fail(kGraphicsError, error.what());
  } catch (const foreview::Interrupted& error) {
    return fail(kInterrupted, error.what());
  } catch (const std::exception& error) {
    return fail(kInternalError, std::string("internal error: ") + error.what());
  }
}
