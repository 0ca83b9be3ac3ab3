// A second checker of claims by sections, written from docs/certificates.md alone: c++ -O2 -std=c++17 section_checker.cpp -o section_checker.
//
// section_checker FILE [--max-states N] [--seconds S] prints "proved", "refuted" or "not checked" and the key of each claim of
// sections.json, and ends with 0, 1 or 2. Why nothing is checked is told in one sentence.
#include "section_formulas.hpp"
#include "section_nominal.hpp"
#include "shapes.hpp"

namespace {

const std::map<std::string, std::set<std::string>> kEnds{
    {"can_succeed", {"succeed"}}, {"can_fail", {"fail"}}, {"can_be_aborted", {"abort"}},
    {"can_always_end", {"succeed", "fail", "abort"}}, {"can_always_end_safely", {"succeed", "abort"}}};

// Kinds that state something.
const std::set<std::string> kStated{"formula", "nominal_success"};

struct Claim { std::string key, kind; bool holds; const Json* statement; };

// Reads what a claim states. Formulas are of no net: their places are any.
void stated(const Json& of, const std::string& kind) {
  if (kind == "formula") {
    keys(of, {"text", "formula"}, "what a formula states");
    text(of.at("text"));
    shape_of_formula(of.at("formula"), std::numeric_limits<Int>::max());
  } else {
    keys(of, {"fails", "endless", "meant", "repaired"}, "what nominal success states");
    for (const char* key : {"fails", "endless", "meant", "repaired"}) texts(of.at(key));
  }
}

std::vector<Claim> claims_of(const Json& of) {
  keys(of, {"format", "version", "mission", "claims", "trusted"}, "sections.json");
  header(of);
  text(of.at("mission"));
  std::set<std::string> once;
  std::vector<Claim> found;
  for (const Json& each : list(of.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    texts(each.at("subject"));
    text(each.at("sentence"));
    found.push_back({text(each.at("key")), text(each.at("kind")), truth(each.at("holds")), &each.at("statement")});
    const bool stating = kStated.count(found.back().kind) > 0;
    require(stating || kEnds.count(found.back().kind) || found.back().kind == "can_always_go_on", "a kind that is not known: " + found.back().kind);
    keys(each.at("evidence"), {}, "the evidence of " + found.back().key);
    if (stating) stated(each.at("statement"), found.back().kind);
    else keys(each.at("statement"), {}, "the statement of " + found.back().key);
  }
  for (const Json& each : list(of.at("trusted"))) {
    keys(each, {"key", "sentence", "why"}, "what is trusted");
    for (const char* key : {"key", "sentence", "why"}) text(each.at(key));
  }
  return found;
}

bool proved(const Claim& claim, const Sections& sections, const SectionFormulas& formulas) {
  if (claim.kind == "formula") return formulas.truth(claim.statement->at("formula")) == (claim.holds ? Truth::yes : Truth::no);
  if (claim.kind == "nominal_success") return claim.holds && SectionNominal(sections).holds(*claim.statement);
  const std::set<std::string> reached = sections.reached();
  if (claim.kind == "can_always_go_on")
    return claim.holds && std::all_of(reached.begin(), reached.end(), [&](const std::string& each) { return !sections.has(each) || sections.goes_on(each); });
  const std::set<std::string>& meant = kEnds.at(claim.kind);
  const auto is_meant = [&](const std::string& each) { return meant.count(each) > 0; };
  if (claim.kind.rfind("can_always", 0) != 0) {
    const std::set<std::string> led = claim.holds ? sections.reached_without_losses() : reached;
    return std::any_of(led.begin(), led.end(), is_meant) == claim.holds;
  }
  if (!claim.holds) return false;
  const std::set<std::string> good = sections.good(meant);
  return std::all_of(reached.begin(), reached.end(), [&](const std::string& each) { return good.count(each) > 0; });
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path, {"core.json", "sections.json"});
  const Json json = parsed(files.at("core.json"));
  const Core core(json);
  const Json claimed = parsed(files.at("sections.json"));
  const std::vector<Claim> claims = claims_of(claimed);
  std::unique_ptr<Sections> sections;
  std::unique_ptr<SectionFormulas> formulas;
  try {
    sections = std::make_unique<Sections>(json, core, clock);
    formulas = std::make_unique<SectionFormulas>(*sections);
  } catch (const Limit& limit) {
    std::cerr << path << ": not checked: " << limit.what() << '\n';
  }
  bool refuted = false, open = !sections || claims.empty();
  for (const Claim& each : claims) {
    const bool is = sections && proved(each, *sections, *formulas);
    refuted = refuted || (sections && !is);
    std::cout << (!sections ? "not checked " : is ? "proved " : "refuted ") << each.key << '\n';
  }
  if (sections) std::cerr << sections->count() << " sections of " << sections->types() << " types, " << sections->states() << " states\n";
  return refuted ? 1 : open ? 2 : 0;
}

}  // namespace

int main(int count, char** words) { return answered(count, words, "--max-states", checked); }
