// A second checker of controllers by types of sections, written from docs/certificates.md, docs/formats.md and docs/controller.md.
//
// section_controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]
#include "section_controller.hpp"
#include "walked.hpp"

std::string walked(const std::string& certificate, const std::string& path, const Clock& clock) {
  const Json json = parsed(unzipped(certificate, {"core.json"}).at("core.json"));
  const Core core(json);
  const Controller controller = controller_of(path);
  if (text(controller.of.at("form")) == "flat") throw Limit("a flat controller has no sections");
  const Sections sections(json, core, clock);
  SectionController walk(core, sections, controller, clock);
  walk.all();
  return std::to_string(walk.count) + " sections, " + std::to_string(walk.walked) + " of them walked: " + std::to_string(walk.pairs) +
         " pairs of states, " + std::to_string(walk.events) + " events";
}

int main(int count, char** words) { return verdict_on_controller(count, words, walked); }
