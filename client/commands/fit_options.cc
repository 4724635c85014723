#include "client/commands/fit_options.h"

#include <map>

namespace cagefit::client {
namespace {

template <typename Enum>
using Names = std::map<std::string, Enum>;

// A flag whose value is one of `names`; `set` takes what it stands for.
template <typename Enum, typename Set>
void AddChoice(CLI::App* command, const std::string& flag, const Names<Enum>& names,
               const std::string& text, const Set& set) {
  std::vector<std::string> choices;
  for (const auto& [name, value] : names) choices.push_back(name);
  command
      ->add_option_function<std::string>(
          flag, [names, set](const std::string& name) { set(names.at(name)); }, text)
      ->check(CLI::IsMember(choices));
}

template <typename Value, typename Set>
void AddValue(CLI::App* command, const std::string& flag, const std::string& text, const Set& set) {
  command->add_option_function<Value>(flag, set, text);
}

// Flags that change the result.
void AddFitSettings(v1::FitOptions* fit, CLI::App* command) {
  AddValue<double>(command, "--radius", "Radius of the distance field, units; 0: by the spacing",
                   [fit](double value) { fit->set_radius(value); });
  AddValue<double>(command, "--radius-factor", "Radius in multiples of the cloud's spacing",
                   [fit](double value) { fit->set_radius_factor(value); });
  AddValue<double>(command, "--far-radius", "Beyond it a sample is drawn to the nearest point",
                   [fit](double value) { fit->set_far_radius(value); });
  AddValue<double>(command, "--arap-weight", "Weight of the regulariser",
                   [fit](double value) { fit->set_arap_weight(value); });
  AddChoice<v1::RestMesh>(
      command, "--rest",
      {{"template", v1::REST_MESH_TEMPLATE}, {"previous", v1::REST_MESH_PREVIOUS_FRAME}},
      "Shape that the regulariser holds to",
      [fit](v1::RestMesh rest) { fit->set_rest_mesh(rest); });
  AddChoice<v1::Sampling>(command, "--sampling",
                          {{"control-vertices", v1::SAMPLING_CONTROL_VERTICES},
                           {"refined-vertices", v1::SAMPLING_REFINED_VERTICES}},
                          "Points of the surface that are held to the target",
                          [fit](v1::Sampling sampling) { fit->set_sampling(sampling); });
  AddChoice<v1::Solver>(command, "--solver",
                        {{"gauss-newton", v1::SOLVER_GAUSS_NEWTON}, {"ceres", v1::SOLVER_CERES}},
                        "Solver", [fit](v1::Solver solver) { fit->set_solver(solver); });
  AddValue<uint32_t>(command, "--max-iterations", "Solver steps of a frame at most",
                     [fit](uint32_t value) { fit->set_max_iterations(value); });
  AddValue<double>(command, "--relative-decrease", "Stop when a step lowers the energy by less",
                   [fit](double value) { fit->set_relative_decrease(value); });
  AddValue<double>(command, "--first-stiffness", "Start with this multiple of the regulariser",
                   [fit](double value) { fit->set_first_stiffness(value); });
}

void AddDeltaSettings(v1::SessionOptions* options, CLI::App* command) {
  AddValue<double>(command, "--quantum",
                   "Grid of the control vertices, share of the diagonal; 0: float32 positions",
                   [options](double value) { options->set_quantum(value); });
  AddChoice<v1::DeltaEncoding>(
      command, "--delta-encoding",
      {{"packed", v1::DELTA_ENCODING_PACKED}, {"draco", v1::DELTA_ENCODING_DRACO}},
      "Of the replies", [options](v1::DeltaEncoding value) { options->set_delta_encoding(value); });
  AddValue<uint32_t>(command, "--key-interval", "Frames from one key frame to the next at most",
                     [options](uint32_t value) { options->set_key_interval(value); });
}

}  // namespace

void AddFitFlags(FitArguments* a, CLI::App* command) {
  command
      ->add_option("INPUT", a->inputs,
                   "A file (static), several files or a folder (a sequence, in natural order of "
                   "names): .ply .obj .stl .off .xyz .pcd .drc")
      ->required();
  command->add_option("--out", a->out, "Folder to write to")->required();
  CLI::Option* cage =
      command->add_option("--template", a->cage, "Control mesh to start from (.obj or a mesh)");
  command
      ->add_option("--vertices", a->vertices,
                   "Make the control mesh from the first frame, with so many vertices")
      ->excludes(cage);
  command->add_option("--server", a->server,
                      "HOST:PORT or unix:PATH; default: a server inside this program");
  command->add_option("--config", "File of options, one name=value a line");
  command->add_option("--name", a->name, "Of the session, for people; default: the input");
  command->add_flag("--keep-session", a->keep_session, "Leave the session on the server");
  command->add_flag("--quick", a->quick, "Only the server's sampled distances, no exact ones");
  command->add_flag("--json", a->json, "Print one JSON object a frame, and one at the end");
  command->add_option("--threads", a->threads, "Of the server inside; 0: one per core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  command->add_option("--position-bits", a->position_bits, "Of clouds that are not Draco yet")
      ->capture_default_str()
      ->check(CLI::Range(8, 30));
  AddFitSettings(a->options.mutable_fit(), command);
  AddDeltaSettings(&a->options, command);
}

}  // namespace cagefit::client
