// A second checker of diagrams.json: c++ -O2 -std=c++17 diagram_checker.cpp -o diagram_checker. It was written from docs/certificates.md
// alone, but for cut sets: whoever gave them to diagcheck gave them to this one, too.
//
// diagram_checker FILE [--max-nodes N] [--seconds S] prints "VERDICT KEY" for each claim that sets of markings prove; VERDICT is proved,
// refuted or not checked. It ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in one sentence, with
// exit code 2.
#include "diagram_cuts.hpp"
#include "each_claim.hpp"
#include "runs.hpp"

class Claims : Closures {
 public:
  Claims(const Net& net, const Diagrams& given, const Markings& markings, Families& families)
      : Closures(net, given, markings, families), cuts_(net, given, markings, families), runs_(net, markings) {}

  bool is_reached() {
    return once(reached_, [&] {
      const Node reached = given_.reached;
      return markings_.partners_are_right() && families_.within(markings_.initial(), reached) && is_safe(reached) && is_closed(reached, true);
    });
  }
  bool proved(const std::string& kind, bool holds, const Json& statement, const Json& evidence) {
    if (!is_reached()) return false;
    if (kind == "cut_sets") return cuts_.are_cut_sets(holds, statement, evidence);
    if (kind == "safe") return holds;
    if (kind == "confluent") return holds && is_confluent();
    if (kind == "can_always_go_on") return holds ? goes_on() : runs_.is_stuck(runs_.after(evidence.at("run")));
    if (kind == "can_succeed") return ends(holds, evidence, "success");
    if (kind == "can_fail") return ends(holds, evidence, "failure");
    if (kind == "can_be_aborted") return ends(holds, evidence, "abort");
    const std::set<std::string> roles = kind == "can_always_end" ? kEnds : std::set<std::string>{"success", "abort"};
    if (holds) return always(layers_of(evidence.at("layers"), given_.nodes), roles);
    const Node closed = node_of(evidence.at("closed"), given_.nodes);
    const auto marking = runs_.after(evidence.at("run"));
    return marking && markings_.holds(closed, *marking) && is_closed(closed, true) && markings_.ending(closed, roles) == 0;
  }

 private:
  bool is_safe(Node set) const {
    bool safe = true;
    firing(set, [&](std::size_t t, Node here) {
      const Transition& of = net_.transitions[t];
      for (const Int place : of.produce)
        if (std::find(of.consume.begin(), of.consume.end(), place) == of.consume.end()) safe = safe && markings_.marking(here, std::size_t(place)) == 0;
    });
    return safe;
  }
  bool is_confluent() {
    if (!runs_end() || !families_.within(given_.reached, families_.firsts(given_.ends))) return false;
    bool fine = true;
    const Node stable = markings_.internally(given_.ends, [&](std::size_t t, Node here) { fine = fine && families_.within(markings_.fired(here, t, true), given_.ends); }, true);
    return fine && families_.equals(stable);
  }
  bool goes_on() const {
    Node left = markings_.internally(given_.reached, [](std::size_t, Node) {});
    left = families_.less(left, markings_.ending(left, kEnds));
    for (const std::size_t t : markings_.events) left = families_.less(left, markings_.covered(left, t));
    return left == 0;
  }
  bool ends(bool holds, const Json& evidence, const std::string& role) const {
    if (!holds) return markings_.ending(given_.reached, {role}) == 0;
    const auto marking = runs_.after(evidence.at("run"));
    return marking && runs_.has_ended(*marking, {role});
  }
  bool always(const std::vector<Node>& layers, const std::set<std::string>& roles) {
    return lead_to(layers, roles, markings_.events) && families_.within(given_.reached, layers.empty() ? 0 : layers.back());
  }

  DiagramCuts cuts_;
  Runs runs_;
  std::optional<bool> reached_;
};

void shape(const Json& claim, const Diagrams& given) {
  static const std::set<std::string> kinds{"safe", "confluent", "can_always_go_on", "can_succeed", "can_fail", "can_be_aborted", "can_always_end", "can_always_end_safely", "cut_sets"};
  const std::string& kind = text(claim.at("kind"));
  const bool holds = truth(claim.at("holds"));
  require(kinds.count(kind) > 0, "a kind that is not known: " + kind);
  std::set<std::string> stated, shown;
  if (kind == "cut_sets") stated = {"ends", "hardware", "cuts"}, shown = {"closed", "layers"};
  else if (kind == "can_always_go_on") { if (!holds) shown = {"run"}; }
  else if (kind.rfind("can_always", 0) == 0) { if (holds) shown = {"layers"}; else shown = {"run", "closed"}; }
  else if (kind.rfind("can", 0) == 0 && holds) shown = {"run"};
  keys(claim.at("statement"), stated, "a statement");
  keys(claim.at("evidence"), shown, "evidence");
  if (!stated.empty()) {
    texts(claim.at("statement").at("ends"));
    texts(claim.at("statement").at("hardware"));
    for (const Json& cut : list(claim.at("statement").at("cuts"))) texts(cut);
    layers_of(claim.at("evidence").at("closed"), given.nodes);
  }
  if (shown.count("run")) numbers(claim.at("evidence").at("run"));
  if (shown.count("layers")) layers_of(claim.at("evidence").at("layers"), given.nodes);
  if (shown.count("closed") && stated.empty()) node_of(claim.at("evidence").at("closed"), given.nodes);
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  require(files.count("diagrams.json") > 0, "no diagrams.json");
  const Json entry = parsed(files.at("diagrams.json"));
  keys(entry, {"format", "version", "claims", "order", "partners", "nodes", "pairs", "reached", "layers", "ends", "weights", "again"}, "diagrams.json");
  header(entry);
  std::set<std::string> once;
  for (const Json& each : list(entry.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    texts(each.at("subject"));
    text(each.at("sentence"));
  }
  std::string why;
  std::unique_ptr<Claims> claims;
  Families families(clock.most, clock);
  Diagrams given;
  std::unique_ptr<Markings> markings;
  try {
    given = diagrams_of(entry, net, families);
    markings = std::make_unique<Markings>(net, given, families);
    claims = std::make_unique<Claims>(net, given, *markings, families);
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (claims) for (const Json& each : entry.at("claims").items) shape(each, given);
  return each_claim(entry.at("claims").items, why, [&](const Json& each) {
    return claims->proved(each.at("kind").string, each.at("holds").truth, each.at("statement"), each.at("evidence"));
  });
}

int main(int count, char** words) { return answered(count, words, "--max-nodes", checked); }
