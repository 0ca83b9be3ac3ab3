// Formulas of CTL* on the states of a net: the states in which they are true.
#pragma once

#include "net.hpp"
#include "shapes.hpp"

class Formulas {
 public:
  Formulas(const Net& net, const States& states, const Clock& clock) : net_(net), states_(states), clock_(clock), count_(states.markings.size()) {}

  Set on_states(const Json& of) {
    const auto& parts = of.items;
    const std::string& op = parts[0].string;
    Set found(count_);
    const auto each = [&](auto is) { for (std::size_t s = 0; s < count_; ++s) found[s] = is(s); };
    if (op == "says") {
      each([&](std::size_t s) { return states_.says(s, parts[1].string, parts[2].string); });
    } else if (op == "at most") {
      each([&](std::size_t s) {
        Wide sum = 0;
        for (const Json& pair : parts[2].items) if (states_.markings[s][std::size_t(pair.items[0].value)]) sum += pair.items[1].value;
        return sum <= parts[1].value;
      });
    } else if (op == "fires") {
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return among(edge, parts); }); });
    } else if (op == "deadlock") {
      each([&](std::size_t s) { return states_.edges[s].empty(); });
    } else if (op == "not") {
      found = on_states(parts[1]);
      found.flip();
    } else if (op == "and" || op == "or") {
      const bool all = op == "and";
      found.assign(count_, all);
      for (std::size_t i = 1; i < parts.size(); ++i) {
        const Set part = on_states(parts[i]);
        each([&](std::size_t s) { return all ? found[s] && part[s] : found[s] || part[s]; });
      }
    } else if (op == "EX") {
      const Set next = on_states(parts[1]);
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(next[edge.to]); }); });
    } else if (op == "EU") {
      const Set through = on_states(parts[1]);
      found = on_states(parts[2]);
      grow(found, through);
    } else if (op == "EG") {
      found = on_states(parts[1]);
      for (bool changed = true; changed;) {
        changed = false;
        clock_.look(0);
        for (std::size_t s = 0; s < count_; ++s) {
          const auto& out = states_.edges[s];
          if (found[s] && !out.empty() && std::none_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(found[edge.to]); })) {
            found[s] = false;
            changed = true;
          }
        }
      }
    } else {
      found = some_path(parts[1]);
    }
    return found;
  }

 private:
  bool among(const Edge& edge, const std::vector<Json>& parts) const {
    for (std::size_t i = 1; i < parts.size(); ++i) if (texts(parts[i]) == net_.transitions[std::size_t(edge.transition)].event) return true;
    return false;
  }
  void grow(Set& found, const Set& through) const {
    for (bool changed = true; changed;) {
      changed = false;
      clock_.look(0);
      for (std::size_t s = count_; s-- > 0;) {
        const auto& out = states_.edges[s];
        if (!found[s] && through[s] && std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(found[edge.to]); })) {
          found[s] = true;
          changed = true;
        }
      }
    }
  }

  // Nodes are a state, the step that is taken there, and what is promised of the next node.
  struct Part { enum Op { state, happens, negation, all, any, next, until } op; Set set; const Json* of = nullptr; std::vector<std::size_t> parts; int promise = -1; };
  std::size_t part_of(const Json& of, std::vector<Part>& parts, int& promises) {
    const std::string& op = of.items[0].string;
    Part made{Part::state, {}, &of, {}, -1};
    const auto inner = [&](std::size_t i) { return part_of(of.items[i], parts, promises); };
    const auto add = [&](Part part) { parts.push_back(std::move(part)); return parts.size() - 1; };
    const auto negated = [&](std::size_t part) { return add({Part::negation, {}, nullptr, {part}, -1}); };
    if (op == "happens") made.op = Part::happens;
    else if (op == "not") { made.op = Part::negation; made.parts = {inner(1)}; }
    else if (op == "and" || op == "or") {
      made.op = op == "and" ? Part::all : Part::any;
      for (std::size_t i = 1; i < of.items.size(); ++i) made.parts.push_back(inner(i));
    } else if (op == "X") { made.op = Part::next; made.parts = {inner(1)}; made.promise = promises++; }
    else if (op == "U") { made.op = Part::until; made.parts = {inner(1), inner(2)}; made.promise = promises++; }
    else if (op == "R") {
      const std::size_t first = negated(inner(1)), second = negated(inner(2));
      return negated(add({Part::until, {}, nullptr, {first, second}, promises++}));
    } else made.set = on_states(of);
    return add(std::move(made));
  }
  Set some_path(const Json& formula) {
    std::vector<Part> parts;
    int promises = 0;
    const std::size_t top = part_of(formula, parts, promises);
    if (promises > 16) throw Limit("a formula on paths with more than 16 promises");
    const std::size_t kinds = std::size_t(1) << promises;
    // Nodes: for each state its steps, one that repeats where there is none; for each step the promises.
    std::vector<std::size_t> first{0};
    for (std::size_t s = 0; s < count_; ++s) first.push_back(first.back() + std::max<std::size_t>(1, states_.edges[s].size()));
    const std::size_t count = first.back() * kinds;
    if (count > (std::size_t(1) << 26)) throw Limit("too many nodes beside a formula on paths");
    clock_.look(0);
    std::vector<std::vector<bool>> holds(parts.size(), std::vector<bool>(count));
    for (std::size_t s = 0; s < count_; ++s) {
      for (std::size_t step = first[s]; step < first[s + 1]; ++step) {
        for (std::size_t kind = 0; kind < kinds; ++kind) {
          const std::size_t node = step * kinds + kind;
          for (std::size_t i = 0; i < parts.size(); ++i) {
            const Part& part = parts[i];
            const auto inner = [&](std::size_t which) { return bool(holds[part.parts[which]][node]); };
            bool is = false;
            switch (part.op) {
              case Part::state: is = part.set[s]; break;
              case Part::happens: is = !states_.edges[s].empty() && among(states_.edges[s][step - first[s]], part.of->items); break;
              case Part::negation: is = !inner(0); break;
              case Part::all: is = true; for (std::size_t k = 0; k < part.parts.size(); ++k) is = is && inner(k); break;
              case Part::any: for (std::size_t k = 0; k < part.parts.size(); ++k) is = is || inner(k); break;
              case Part::next: is = kind >> part.promise & 1; break;
              case Part::until: is = inner(1) || (inner(0) && (kind >> part.promise & 1)); break;
            }
            holds[i][node] = is;
          }
        }
      }
    }
    // What is promised of a node: the part behind an X, an until itself.
    const auto promised = [&](std::size_t node) {
      std::size_t kind = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        if (part.op == Part::next && holds[part.parts[0]][node]) kind |= std::size_t(1) << part.promise;
        if (part.op == Part::until && holds[i][node]) kind |= std::size_t(1) << part.promise;
      }
      return kind;
    };
    std::vector<std::uint32_t> made(count);
    for (std::size_t node = 0; node < count; ++node) made[node] = std::uint32_t(promised(node));
    const auto state_of = [&](std::size_t step) { return std::size_t(std::upper_bound(first.begin(), first.end(), step) - first.begin()) - 1; };
    const auto for_next = [&](std::size_t node, auto&& then) {
      const std::size_t step = node / kinds, kind = node % kinds, s = state_of(step);
      const std::size_t to = states_.edges[s].empty() ? s : states_.edges[s][step - first[s]].to;
      for (std::size_t next = first[to] * kinds; next < first[to + 1] * kinds; ++next) if (made[next] == kind) then(next);
    };
    return accepted(count, kinds, first, parts, holds, top, for_next, state_of);
  }
  // States with a node of the formula that leads to a strongly connected component in which no until is put off for ever.
  template <class Next, class StateOf>
  Set accepted(std::size_t count, std::size_t kinds, const std::vector<std::size_t>&, const std::vector<Part>& parts,
               const std::vector<std::vector<bool>>& holds, std::size_t top, const Next& for_next, const StateOf& state_of) const {
    std::vector<std::size_t> index(count), low(count), stack, component(count);
    std::vector<bool> on_stack(count), good(count);
    std::size_t counter = 0;
    struct Frame { std::size_t node; std::vector<std::size_t> next; std::size_t at; };
    for (std::size_t root = 0; root < count; ++root) {
      if (index[root]) continue;
      std::vector<Frame> frames;
      const auto enter = [&](std::size_t node) {
        index[node] = low[node] = ++counter;
        stack.push_back(node);
        on_stack[node] = true;
        Frame frame{node, {}, 0};
        for_next(node, [&](std::size_t next) { frame.next.push_back(next); });
        frames.push_back(std::move(frame));
        if (counter % 4096 == 0) clock_.look(0);
      };
      enter(root);
      while (!frames.empty()) {
        Frame& top_frame = frames.back();
        if (top_frame.at < top_frame.next.size()) {
          const std::size_t next = top_frame.next[top_frame.at++];
          if (!index[next]) enter(next);
          else if (on_stack[next]) low[top_frame.node] = std::min(low[top_frame.node], index[next]);
          continue;
        }
        const std::size_t node = top_frame.node;
        if (low[node] == index[node]) {
          std::vector<std::size_t> members;
          for (;;) {
            const std::size_t member = stack.back();
            stack.pop_back();
            on_stack[member] = false;
            members.push_back(member);
            if (member == node) break;
          }
          bool leads = members.size() > 1, reaches = false;
          for (const std::size_t member : members)
            for_next(member, [&](std::size_t next) { leads = leads || next == member; reaches = reaches || good[next]; });
          for (std::size_t i = 0; leads && i < parts.size(); ++i)
            if (parts[i].op == Part::until)
              leads = std::any_of(members.begin(), members.end(), [&](std::size_t member) { return !holds[i][member] || holds[parts[i].parts[1]][member]; });
          for (const std::size_t member : members) good[member] = leads || reaches;
        }
        frames.pop_back();
        if (!frames.empty()) low[frames.back().node] = std::min(low[frames.back().node], low[node]);
      }
    }
    Set found(count_);
    for (std::size_t node = 0; node < count; ++node) if (good[node] && holds[top][node]) found[state_of(node / kinds)] = true;
    return found;
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  std::size_t count_;
};
