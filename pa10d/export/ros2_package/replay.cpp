// Rows of q, dq, ddq (all joints each, separated by spaces) -> rows of efforts: what the class gives
// on this machine, to be compared with what the model gives elsewhere.
#include <cstdio>
#include <iostream>

#include "@package@/feed_forward.hpp"

int main()
{
  using namespace @package@;
  Parameters parameters;
  parameters.effort_limit.fill(std::numeric_limits<double>::infinity());
  const FeedForward law(parameters);
  Joints q{}, dq{}, ddq{};
  const auto read = [](Joints & row) {
    for (double & value : row) {
      std::cin >> value;
    }
    return static_cast<bool>(std::cin);
  };
  while (read(q) && read(dq) && read(ddq)) {
    for (const double effort : law.update(q, dq, ddq)) {
      std::printf("%.17g ", effort);
    }
    std::printf("\n");
  }
  return 0;
}
