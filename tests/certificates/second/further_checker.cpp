// A second checker of further.json, written from docs/certificates.md alone: c++ -O2 -std=c++17 further_checker.cpp -o further_checker.
//
// further_checker FILE [--max-states N] [--seconds S] prints "VERDICT KEY" for each claim on cut sets at other moments and on probabilities;
// VERDICT is proved, refuted or not checked. It ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in
// one sentence, with exit code 2.
#include "chances.hpp"
#include "each_claim.hpp"
#include "further_shape.hpp"
#include "moments.hpp"

bool proved(const Net& net, const States& states, const Clock& clock, const Json& claim) {
  const std::string& kind = claim.at("kind").string;
  const Json& statement = claim.at("statement");
  if (of_cut_sets(kind)) return Moments(net, states, clock, statement).cut_sets(kind, claim.at("evidence"));
  return Chances(net, states, clock, statement).chance(claim.at("evidence"));
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  require(files.count("further.json") > 0, "no further.json");
  const Json further = parsed(files.at("further.json"));
  keys(further, {"format", "version", "claims"}, "further.json");
  header(further);
  static const std::set<std::string> kinds{"cut_sets_at_start", "cut_sets_at_entry", "cut_sets_whenever", "cut_sets_at_worst", "chance"};
  std::set<std::string> once;
  for (const Json& each : list(further.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    text(each.at("kind"));
    texts(each.at("subject"));
    text(each.at("sentence"));
    truth(each.at("holds"));
    for (const char* key : {"statement", "evidence"}) require(each.at(key).kind == Json::object, "a claim without an object");
  }
  std::unique_ptr<States> states;
  std::string why;
  try {
    states = std::make_unique<States>(net, clock);
  } catch (const Unsafe&) {
    why = "the net is not safe";
  } catch (const NotConfluent&) {
    why = "the net is not confluent";
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (states)  // else no claim is looked into
    for (const Json& each : further.at("claims").items) {
      require(kinds.count(each.at("kind").string) > 0, "a kind that is not known: " + each.at("kind").string);
      if (each.at("holds").truth) shape(each);
    }
  return each_claim(further.at("claims").items, why, [&](const Json& each) { return each.at("holds").truth && proved(net, *states, clock, each); });
}

int main(int count, char** words) { return answered(count, words, "--max-states", checked); }
