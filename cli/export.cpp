// `evograsp export`: a champion for programs that do not read protobuf.
#include <memory>

#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/onnx.h"
#include "cli/output.h"
#include "cli/report.h"

namespace evograsp::cli {
namespace {

struct Options {
  std::string champion, out;
  bool json = false;
};

int run(const Options& options) {
  const auto champion = read_champion(options.champion);
  if (!champion) return report(champion.error());
  const auto model = to_onnx(*champion);
  if (!model) return report(Error{model.error().code, options.champion + ": " + model.error().message});
  if (const Status written = write_file(options.out, *model); !written) return report(written.error());
  const proto::Network& network = champion->network();
  if (options.json) {
    print_json(nlohmann::ordered_json{{"file", options.out},
                                      {"format", "onnx"},
                                      {"bytes", model->size()},
                                      {"inputs", network.inputs()},
                                      {"outputs", network.outputs()}});
  } else {
    say(options.out + ": ONNX, " + std::to_string(network.inputs()) + " inputs, " +
        std::to_string(network.outputs()) + " outputs, " + std::to_string(model->size()) + " bytes");
  }
  return kExitOk;
}

}  // namespace

void add_export(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("export", "write a champion's network as an ONNX model");
  sub->add_option("champion", options->champion, "champion.pb or its run folder")
      ->required()
      ->type_name("CHAMPION");
  sub->add_option("-o,--out", options->out, "file to write")->required()->type_name("FILE");
  sub->add_flag("--json", options->json, "machine-readable");
  sub->footer(
      "Input \"observation\" [N, 304]: depth samples, click, box; output \"action\" [N, 7]: position, axis, "
      "angle. The\n"
      "model's metadata says what they mean and names the experiment. `evograsp champion` gives the champion "
      "itself,\n"
      "as protobuf or JSON.\n\n"
      "Example:\n  evograsp export runs/cube --out cube.onnx");
  sub->callback([options, &outcome] { outcome.exit_code = run(*options); });
}

}  // namespace evograsp::cli
