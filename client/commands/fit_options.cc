#include "client/commands/fit_options.h"

#include <map>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/commands/credential_flags.h"
#include "client/commands/parse_tolerance.h"

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

// A flag and its opposite.
template <typename Set>
void AddSwitch(CLI::App* command, const std::string& on, const std::string& off,
               const std::string& text, const Set& set) {
  command->add_flag_function(
      on + ",!" + off, [set](int64_t value) { set(value > 0); }, text);
}

// What the fit is held to, and how the target is read.
void AddTargetSettings(v1::FitOptions* fit, CLI::App* command) {
  AddChoice<v1::Preset>(command, "--preset",
                        {{"default", v1::PRESET_DEFAULT}, {"paper", v1::PRESET_PAPER}},
                        "Where options that are not given come from",
                        [fit](v1::Preset preset) { fit->set_preset(preset); });
  AddSwitch(command, "--remove-outliers", "--keep-outliers",
            "Leave out points far from all others, or keep them",
            [fit](bool on) { fit->set_remove_outliers(on); });
  AddSwitch(command, "--repair-normals", "--keep-normals",
            "Turn normals that face against their neighbours, or keep them",
            [fit](bool on) { fit->set_repair_normals(on); });
  AddChoice<v1::Kernel>(command, "--kernel",
                        {{"identity", v1::KERNEL_IDENTITY},
                         {"huber", v1::KERNEL_HUBER},
                         {"geman-mcclure", v1::KERNEL_GEMAN_MCCLURE},
                         {"tukey", v1::KERNEL_TUKEY}},
                        "How much a distance counts",
                        [fit](v1::Kernel kernel) { fit->set_kernel(kernel); });
  AddValue<double>(command, "--kernel-scale",
                   "Where the kernel sets in, units; 0: twice the noise of each frame",
                   [fit](double value) { fit->set_kernel_scale(value); });
  AddValue<double>(command, "--coverage-weight",
                   "Weight of the distance from the target to the surface; 0: none",
                   [fit](double value) { fit->set_coverage_weight(value); });
  AddValue<uint32_t>(command, "--coverage-points",
                     "Points of the target that take part in that, per control vertex",
                     [fit](uint32_t value) { fit->set_coverage_points_per_vertex(value); });
  AddValue<double>(command, "--boundary-weight",
                   "Weight of the distance of the surface's open boundary to the target's; 0: none",
                   [fit](double value) { fit->set_boundary_weight(value); });
  AddValue<double>(command, "--landmark-weight", "Weight of the landmarks; 0: none",
                   [fit](double value) { fit->set_landmark_weight(value); });
}

void AddFieldSettings(v1::FitOptions* fit, CLI::App* command) {
  AddChoice<v1::Field>(command, "--field", {{"imls", v1::FIELD_IMLS}, {"rimls", v1::FIELD_RIMLS}},
                       "Distance field", [fit](v1::Field field) { fit->set_field(field); });
  AddValue<double>(command, "--radius", "Radius of the distance field, units; 0: by the spacing",
                   [fit](double value) { fit->set_radius(value); });
  AddValue<double>(command, "--radius-share",
                   "Radius as a share of the longest side of the first frame's box",
                   [fit](double value) { fit->set_radius_share(value); });
  AddValue<double>(command, "--radius-factor", "Radius in multiples of the cloud's spacing",
                   [fit](double value) { fit->set_radius_factor(value); });
  AddValue<double>(command, "--first-radius",
                   "Start with this multiple of the radius and halve it; 0: automatic",
                   [fit](double value) { fit->set_first_radius(value); });
  AddValue<double>(command, "--far-radius", "Beyond it a sample is drawn to the nearest point",
                   [fit](double value) { fit->set_far_radius(value); });
  AddChoice<v1::Sampling>(command, "--sampling",
                          {{"control-vertices", v1::SAMPLING_CONTROL_VERTICES},
                           {"refined-vertices", v1::SAMPLING_REFINED_VERTICES},
                           {"area", v1::SAMPLING_AREA}},
                          "Points of the surface that are held to the target",
                          [fit](v1::Sampling sampling) { fit->set_sampling(sampling); });
  AddValue<uint32_t>(command, "--samples-per-triangle", "With --sampling area",
                     [fit](uint32_t value) { fit->set_samples_per_triangle(value); });
}

void AddSolverSettings(v1::FitOptions* fit, CLI::App* command) {
  AddValue<double>(command, "--arap-weight", "Weight of the regulariser",
                   [fit](double value) { fit->set_arap_weight(value); });
  AddChoice<v1::RestMesh>(
      command, "--rest",
      {{"template", v1::REST_MESH_TEMPLATE}, {"previous", v1::REST_MESH_PREVIOUS_FRAME}},
      "Shape that the regulariser holds to",
      [fit](v1::RestMesh rest) { fit->set_rest_mesh(rest); });
  AddChoice<v1::Solver>(command, "--solver",
                        {{"gauss-newton", v1::SOLVER_GAUSS_NEWTON},
                         {"ceres", v1::SOLVER_CERES},
                         {"adam", v1::SOLVER_ADAM}},
                        "Solver", [fit](v1::Solver solver) { fit->set_solver(solver); });
  AddValue<uint32_t>(command, "--max-iterations", "Solver steps of a frame at most",
                     [fit](uint32_t value) { fit->set_max_iterations(value); });
  AddValue<double>(command, "--relative-decrease", "Stop when a step lowers the energy by less",
                   [fit](double value) { fit->set_relative_decrease(value); });
  AddValue<double>(command, "--first-stiffness", "Start with this multiple of the regulariser",
                   [fit](double value) { fit->set_first_stiffness(value); });
  AddValue<double>(command, "--learning-rate", "Of Adam",
                   [fit](double value) { fit->set_learning_rate(value); });
}

void AddImageSettings(v1::FitOptions* fit, CLI::App* command) {
  AddValue<double>(command, "--distance-weight",
                   "Weight of the distance from the surface to the target; 0: none",
                   [fit](double value) { fit->set_distance_weight(value); });
  AddChoice<v1::Views>(command, "--image-views",
                       {{"none", v1::VIEWS_NONE},
                        {"cameras", v1::VIEWS_CAMERAS},
                        {"sphere", v1::VIEWS_SPHERE},
                        {"tutorial", v1::VIEWS_TUTORIAL}},
                       "Compare images, too: masks of --cameras, or of virtual cameras",
                       [fit](v1::Views views) { fit->mutable_image()->set_views(views); });
  AddValue<double>(command, "--image-weight", "Weight of the images; default: automatic",
                   [fit](double value) { fit->mutable_image()->set_weight(value); });
  AddChoice<v1::SilhouetteMode>(
      command, "--image-mode",
      {{"outline", v1::SILHOUETTE_MODE_OUTLINE}, {"pytorch3d", v1::SILHOUETTE_MODE_PYTORCH3D}},
      "How silhouettes are drawn",
      [fit](v1::SilhouetteMode mode) { fit->mutable_image()->set_mode(mode); });
  AddValue<uint32_t>(command, "--image-size", "Pixels of the longer side",
                     [fit](uint32_t value) { fit->mutable_image()->set_size(value); });
  AddValue<uint32_t>(command, "--image-view-count", "Virtual views",
                     [fit](uint32_t value) { fit->mutable_image()->set_view_count(value); });
  AddValue<uint32_t>(
      command, "--image-views-per-iteration", "Views drawn in each solver step; 0: all",
      [fit](uint32_t value) { fit->mutable_image()->set_views_per_iteration(value); });
  AddValue<double>(command, "--image-sigma", "Softness of edges, squared; unit: half the side",
                   [fit](double value) { fit->mutable_image()->set_sigma(value); });
  AddValue<double>(command, "--image-blur-radius", "With --image-mode pytorch3d, squared",
                   [fit](double value) { fit->mutable_image()->set_blur_radius(value); });
  AddValue<uint32_t>(command, "--image-faces-per-pixel", "With --image-mode pytorch3d",
                     [fit](uint32_t value) { fit->mutable_image()->set_faces_per_pixel(value); });
  AddValue<double>(command, "--image-depth-weight", "Of depth images, share of --image-weight",
                   [fit](double value) { fit->mutable_image()->set_depth_weight(value); });
  AddValue<double>(command, "--image-normal-weight", "Of normal images, share of --image-weight",
                   [fit](double value) { fit->mutable_image()->set_normal_weight(value); });
  AddValue<uint64_t>(command, "--image-seed", "Of the views that are drawn",
                     [fit](uint64_t value) { fit->mutable_image()->set_seed(value); });
  AddValue<double>(
      command, "--image-calibration-error",
      "Pixels by which a camera's calibration may be off; each fit finds out by how much",
      [fit](double value) { fit->mutable_image()->set_calibration_error(value); });
}

void AddDeltaSettings(v1::SessionOptions* options, CLI::App* command) {
  AddValue<double>(command, "--quantum",
                   "Grid of the control vertices, share of the diagonal; 0: float32 positions",
                   [options](double value) { options->set_quantum(value); });
  AddChoice<v1::Priority>(command, "--priority",
                          {{"live", v1::PRIORITY_LIVE}, {"batch", v1::PRIORITY_BATCH}},
                          "batch: get what live sessions leave of the server",
                          [options](v1::Priority value) { options->set_priority(value); });
  AddChoice<v1::DeltaEncoding>(
      command, "--delta-encoding",
      {{"packed", v1::DELTA_ENCODING_PACKED}, {"draco", v1::DELTA_ENCODING_DRACO}},
      "Of the replies", [options](v1::DeltaEncoding value) { options->set_delta_encoding(value); });
  AddValue<uint32_t>(command, "--key-interval", "Frames from one key frame to the next at most",
                     [options](uint32_t value) { options->set_key_interval(value); });
}

// Many captures in one call.
void AddTakeFlags(FitArguments* a, CLI::App* command) {
  CLI::Option* takes = command->add_flag(
      "--takes", a->takes,
      "Every INPUT, a folder or a file, is a take of its own, fitted into OUT/NAME by its name. "
      "Takes that are done are skipped, half-done ones go on, also after a crash. {take} in paths "
      "of --template, --cameras, --masks, --landmarks and --truth stands for the name");
  for (const char* one : {"--session", "--follow"}) takes->excludes(command->get_option(one));
  command
      ->add_option_function<std::string>(
          "--chunk",
          [a](const std::string& text) {
            const std::pair<std::string, std::string> parts = absl::StrSplit(text, '/');
            if (absl::SimpleAtoi(parts.first, &a->chunk) &&
                absl::SimpleAtoi(parts.second, &a->chunks) && a->chunk < a->chunks) {
              return;
            }
            throw CLI::ValidationError(
                absl::StrCat("--chunk: \"", text, "\" is not K/N with K from 0 to N-1, as in 0/8"));
          },
          "K/N: of the takes, in natural order, only every N-th, from number K on; K from 0 to N-1")
      ->needs(takes);
}

// Which frames are fitted, and when.
void AddSequenceFlags(FitArguments* a, CLI::App* command) {
  command
      ->add_option(
          "--session", a->session,
          "Go on with this session of the server, as the command says that a broken-off fit "
          "prints; frames that it has answered are fetched, not fitted again")
      ->needs("--server");
  command
      ->add_option("--give-up", a->give_up,
                   "Seconds to go on trying when the server is away and no reply comes")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6));
  command->add_option(
      "--from-frame", a->from_frame,
      "Leave out the frames before this one, counted from 0. A new session then starts with the "
      "last control mesh before it in OUT/frames, where there is one, instead of --template or "
      "--vertices. With --session: the frame that it began with");
  command->add_option("--to-frame", a->to_frame, "Leave out the frames behind this one");
  CLI::Option* follow = command->add_flag(
      "--follow", a->follow,
      "INPUT is a folder that is being written to: take its files as they are completed, in "
      "natural "
      "order, until Ctrl-C. A file that is renamed to its name is complete at once");
  for (const char* whole : {"--masks", "--landmarks", "--truth", "--round-trip", "--to-frame"}) {
    follow->excludes(command->get_option(whole));
  }
  command
      ->add_option("--follow-settle", a->follow_settle,
                   "Other files are complete when they have not changed for so many seconds")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3600.0))
      ->needs(follow);
  command
      ->add_option("--follow-idle", a->follow_idle, "End after so many seconds without a new file")
      ->check(CLI::Range(0.001, 1e6))
      ->needs(follow);
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
  command
      ->add_option(
          "--crease-angle", a->crease_angle,
          "Degrees: sharper edges of that mesh become creases; 0: none; default: automatic")
      ->excludes(cage);
  command->add_option_function<std::string>(
      "--tolerance",
      [a](const std::string& text) {
        const auto share = ParseTolerance(text);
        if (!share.ok()) throw CLI::ValidationError(std::string(share.status().message()));
        a->options.set_tolerance(*share);
      },
      "Add control vertices until all points of the first frame but the farthest 0.1 % are within "
      "it: percent of the diagonal, as in 0.1%, or a share, as in 0.001");
  AddValue<uint32_t>(command, "--max-vertices", "With --tolerance: control vertices at most",
                     [a](uint32_t value) { a->options.set_max_vertices(value); });
  CLI::Option* cameras =
      command->add_option("--cameras", a->cameras,
                          "Calibrated cameras: a .json file, or a folder with COLMAP's text model");
  command
      ->add_option("--masks", a->masks,
                   "Folder of masks, MASKS/CAMERA/FRAME.png: FRAME is the name of the input file "
                   "without its ending; what is missing is a camera that did not see the frame")
      ->needs(cameras);
  command->add_option("--landmarks", a->landmarks,
                      "File of places whose position is known, one a line: FRAME vertex INDEX X Y "
                      "Z, or FRAME surface TRIANGLE U V X Y Z; FRAME is the name of the input file "
                      "without its ending");
  command->add_option("--server", a->server,
                      "HOST:PORT or unix:PATH; default: a server inside this program");
  AddCredentialFlags(&a->credentials, command);
  command->add_option("--config", "File of options, one name=value a line");
  command->add_option("--name", a->name, "Of the session, for people; default: the input");
  command->add_flag("--keep-session", a->keep_session, "Leave the session on the server");
  CLI::Option* truth =
      command->add_option("--truth", a->truth,
                          "Measure drift against the true motion: a folder, or files, of meshes "
                          "whose vertices correspond, one a frame");
  command
      ->add_flag("--round-trip", a->round_trip,
                 "Measure drift without it: fit the frames forth and back again")
      ->excludes(truth);
  command->add_flag("--latest", a->latest,
                    "As a live rig: the server skips frames that it cannot keep up with");
  AddFormatFlags(&a->formats, command);
  command->add_flag("--quick", a->quick, "Only the server's sampled distances, no exact ones");
  command->add_flag("--report", a->report,
                    "Write OUT/report.html, too: a page that shows the fit in any browser");
  command->add_flag("--json", a->json, "Print one JSON object a frame, and one at the end");
  command->add_option("--threads", a->threads, "Of the server inside; 0: one per core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  command->add_option("--position-bits", a->position_bits, "Of clouds that are not Draco yet")
      ->capture_default_str()
      ->check(CLI::Range(8, 30));
  AddSequenceFlags(a, command);
  AddTakeFlags(a, command);
  AddTargetSettings(a->options.mutable_fit(), command);
  AddFieldSettings(a->options.mutable_fit(), command);
  AddSolverSettings(a->options.mutable_fit(), command);
  AddImageSettings(a->options.mutable_fit(), command);
  AddDeltaSettings(&a->options, command);
}

}  // namespace cagefit::client
