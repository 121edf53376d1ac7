// The efforts that a motion needs, by the model in model.h. Knows nothing of ROS; does not allocate
// and keeps nothing from call to call, so that any loop may call it.
#ifndef @guard@_HPP
#define @guard@_HPP

#include <array>
#include <cstddef>
#include <limits>

#include "@package@/model.h"

namespace @package@
{

using Joints = std::array<double, @joints@>;

// In the order of every array here.
inline constexpr std::array<const char *, @joints@> kJointNames{{@names@}};
inline constexpr std::array<const char *, @joints@> kEffortInterfaces{{@interfaces@}};

struct Parameters
{
  double scale = 1.0;  // of the model's effort: begin with less where the model is new
  Joints effort_limit{{@limits@}};  // N m (N), to either side
};

class FeedForward
{
public:
  FeedForward() = default;
  explicit FeedForward(const Parameters & parameters) : parameters_(parameters) {}

  // q: rad (m), dq, ddq of the motion that is wanted -> effort, N m (N). With measured q and dq and
  // the wanted ddq it is computed torque. What is not finite in is not finite out: look before
  // you send.
  Joints update(const Joints & q, const Joints & dq, const Joints & ddq) const noexcept
  {
    Joints effort{};
    @model@_torque(q.data(), dq.data(), ddq.data(), effort.data());
    return limited(effort);
  }

  // What holds the arm in a pose, friction not counted.
  Joints gravity(const Joints & q) const noexcept
  {
    Joints effort{};
    @model@_gravity(q.data(), effort.data());
    return limited(effort);
  }

private:
  Joints limited(Joints effort) const noexcept
  {
    for (std::size_t j = 0; j < effort.size(); ++j) {
      const double limit = parameters_.effort_limit[j];
      effort[j] *= parameters_.scale;
      if (effort[j] > limit) {
        effort[j] = limit;
      } else if (effort[j] < -limit) {
        effort[j] = -limit;
      }
    }
    return effort;
  }

  Parameters parameters_{};
};

}  // namespace @package@

#endif
