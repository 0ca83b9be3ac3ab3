// FORCE (Aloul, Markov, Sakallah, GLSVLSI 2003): orders in which what belongs together stands together.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace mcpn {

using Groups = std::vector<std::vector<std::uint32_t>>;

// Each round moves every member to the mean of the centres of its groups, wide groups pulling less; the order of
// least total span, each divided by the group's width, is kept. It ends after ten rounds without a better one.
std::vector<std::uint32_t> force(const Groups& groups, const std::vector<std::uint32_t>& start, unsigned rounds) {
  const std::size_t count = start.size();
  std::vector<double> position(count), pulled(count), total(count, 0);
  for (std::size_t i = 0; i < count; ++i) position[start[i]] = double(i);
  for (const auto& group : groups)
    for (const std::uint32_t member : group) total[member] += 1.0 / double(group.size());
  const auto span = [&] {
    double sum = 0;
    for (const auto& group : groups) {
      if (group.empty()) continue;
      double least = position[group[0]], most = least;
      for (const std::uint32_t member : group) {
        least = std::min(least, position[member]);
        most = std::max(most, position[member]);
      }
      sum += (most - least) / double(group.size());
    }
    return sum;
  };
  std::vector<std::uint32_t> order = start, best = start;
  double least = span();
  for (unsigned round = 0, stale = 0; round < rounds && stale <= 10; ++round) {
    std::fill(pulled.begin(), pulled.end(), 0);
    for (const auto& group : groups) {
      double centre = 0;
      for (const std::uint32_t member : group) centre += position[member];
      const double width = double(group.size());
      for (const std::uint32_t member : group) pulled[member] += 1.0 / width * (centre / width);
    }
    for (std::size_t i = 0; i < count; ++i) pulled[i] = total[i] > 0 ? pulled[i] / total[i] : position[i];
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return pulled[a] < pulled[b]; });
    for (std::size_t i = 0; i < count; ++i) position[order[i]] = double(i);
    const double now = span();
    stale = now < least ? 0 : stale + 1;
    if (now < least) {
      least = now;
      best = order;
    }
  }
  return best;
}

}  // namespace mcpn
