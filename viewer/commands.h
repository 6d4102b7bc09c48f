#pragma once

namespace CLI {
class App;
}

namespace foreview {

/// Each adds one subcommand with its options, its help with an example, and a callback that does the work. Callbacks
/// throw InputError (exit status 2), GraphicsError (3) or Interrupted (130); main() prints the one line.
void add_inspect_command(CLI::App& app);
void add_generate_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_evaluate_command(CLI::App& app);
void add_export_command(CLI::App& app);
void add_bench_command(CLI::App& app);
void add_send_command(CLI::App& app);
void add_serve_command(CLI::App& app);
void add_record_command(CLI::App& app);

}  // namespace foreview
