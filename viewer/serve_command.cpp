#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "foreview/server/republisher.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_options_cli.h"

namespace foreview {
namespace {

constexpr const char* kStatisticsTopic = "/foreview/statistics";

struct ServeCommand {
  LiveOptionsCli live;
  std::string duration;
  bool stats = false, republishes = false;

  void run() const;
};

nlohmann::ordered_json statistics(LiveSource& source, const LiveReceiver& receiver) {
  const SourceStatus status = source.status();
  const LiveSource::Latency latency = source.latency();
  const auto ms = [](Duration duration) { return static_cast<double>(duration.nanoseconds) * 1e-6; };
  nlohmann::ordered_json json;
  json["pictures"] = {{"in", status.pictures_in},
                      {"used", status.used},
                      {"overwritten", status.overwritten},
                      {"damaged", status.damaged},
                      {"stateless", status.stateless},
                      {"duplicated", status.duplicated},
                      {"lost", status.lost + receiver.lost()}};
  json["latency_ms"] = {{"median", ms(latency.median)},
                        {"p99", ms(latency.p99)},
                        {"decoding_median", ms(latency.decoding_median)},
                        {"decoding_share", latency.decoding_share},
                        {"transport_median", ms(latency.transport_median)}};
  json["clock_drift_ppm"] = latency.drift * 1e6;
  json["missing"] = receiver.missing();
  return json;
}

void print(const nlohmann::ordered_json& json) {
  const auto& pictures = json["pictures"];
  const auto& latency = json["latency_ms"];
  std::printf(
      "pictures: %zu in, %zu used, %zu overwritten, %zu damaged, %zu without state, %zu lost | "
      "last packet to available: median %.2f ms, p99 %.2f ms, %.0f %% of it decoding%s%s\n",
      pictures["in"].get<std::size_t>(), pictures["used"].get<std::size_t>(),
      pictures["overwritten"].get<std::size_t>(), pictures["damaged"].get<std::size_t>(),
      pictures["stateless"].get<std::size_t>(), pictures["lost"].get<std::size_t>(), latency["median"].get<double>(),
      latency["p99"].get<double>(), latency["decoding_share"].get<double>() * 100,
      json["missing"].get<std::string>().empty() ? "" : " | ", json["missing"].get<std::string>().c_str());
  std::fflush(stdout);
}

void ServeCommand::run() const {
  const Duration length = duration.empty() ? Duration{} : Duration::parse(duration, "--duration");
  DdsNode node(live.network.options());
  LiveSource source(live.source());
  std::vector<std::string> names;
  for (const CameraTopics& topics : live.cameras()) names.push_back(camera_name(topics.image));
  std::unique_ptr<Republisher> republisher;
  if (republishes) republisher = std::make_unique<Republisher>(node, names, live.world_frame);
  const auto statistics_writer = node.advertise<TextMessage>(kStatisticsTopic, QosProfile::reliable);
  const LiveReceiver receiver(node, live.cameras(), source);
  const Timestamp begun = steady_now();
  Timestamp told = begun;
  while (!interrupted() && (duration.empty() || steady_now() - begun < length)) {
    while (const auto frame = source.take()) {
      if (republisher) republisher->send(*frame);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (steady_now() - told < Duration{1'000'000'000}) continue;
    told = steady_now();
    const nlohmann::ordered_json json = statistics(source, receiver);
    statistics_writer->write({json.dump()});
    if (stats) print(json);
  }
  if (stats) print(statistics(source, receiver));
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto* command = app.add_subcommand("serve", "The image server alone: hear live streams, decode, keep the newest");
  auto state = std::make_shared<ServeCommand>();
  command->add_flag(
      "--stats", state->stats,
      std::string("Print statistics every second; they are on topic ") + kStatisticsTopic + " in any case");
  command->add_flag("--republish", state->republishes,
                    "Publish decoded pictures with camera_info and pose, for a display elsewhere: /foreview/NAME/...");
  command->add_option("--duration", state->duration, "End by itself after this time; else with Ctrl-C")
      ->type_name("TIME");
  state->live.add_to(*command);
  command->footer("Example: foreview serve --topic /camera/image_raw/compressed --stats");
  command->callback([state] { state->run(); });
}

}  // namespace foreview
