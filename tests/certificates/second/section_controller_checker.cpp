// A second checker of controllers by types of sections, written from docs/certificates.md, docs/formats.md and docs/controller.md.
//
// section_controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]
#include "section_controller.hpp"

int checked(const std::string& certificate, const std::string& path, const Clock& clock) {
  const Json json = parsed(unzipped(certificate, {"core.json"}).at("core.json"));
  const Core core(json);
  std::ifstream file(path, std::ios::binary);
  require(bool(file), "a controller that cannot be read");
  Json document = parsed(std::string((std::istreambuf_iterator<char>(file)), {}), true);
  require(document.kind == Json::object, "a controller that is no object");
  const Controller controller(std::move(document));
  try {
    if (text(controller.of.at("form")) == "flat") throw Limit("a flat controller has no sections");
    const Sections sections(json, core, clock);
    SectionController walk(core, sections, controller, clock);
    walk.all();
    std::cout << "proved controller: " << walk.count << " sections, " << walk.walked << " of them walked: " << walk.pairs << " pairs of states, " << walk.events << " events\n";
    return 0;
  } catch (const Refuted& why) {
    std::cout << "refuted controller: " << why.what() << '\n';
    return 1;
  } catch (const Limit& limit) {
    std::cout << "not checked controller: " << limit.what() << '\n';
  }
  return 2;
}

int main(int count, char** words) {
  if (count < 3) {
    std::cerr << "usage: section_controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]\n";
    return 2;
  }
  const std::string certificate = words[1];
  return answered(count - 1, words + 1, "--max-states",
                  [&](const std::string& path, const Clock& clock) { return checked(certificate, path, clock); });
}
