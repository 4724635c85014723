// Makes templates with a program of its own, run as a child: surface reconstruction crashes and
// leaks in long-lived processes, and its libraries are heavy.
#ifndef CAGEFIT_SERVER_SESSION_TEMPLATE_PROCESS_H_
#define CAGEFIT_SERVER_SESSION_TEMPLATE_PROCESS_H_

#include <string>

#include "server/session/child_process.h"
#include "server/session/template_maker.h"

namespace cagefit::server {

// Runs "PROGRAM template INPUT.drc --vertices N --out CAGE.obj" in a private folder, with
// "--crease-angle DEGREES" where one is given.
class TemplateProcess : public TemplateMaker {
 public:
  TemplateProcess(std::string program, const ChildLimits& limits);

  absl::Status CheckAvailable() const override;
  absl::StatusOr<ControlMesh> Make(absl::string_view draco, const TemplateRequest& request,
                                   const CancelFn& cancelled) override;

 private:
  const std::string program_;  // path
  const ChildLimits limits_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_TEMPLATE_PROCESS_H_
