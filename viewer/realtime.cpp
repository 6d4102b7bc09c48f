#include "foreview/viewer/realtime.h"

#include <pthread.h>
#include <sched.h>

#include <system_error>

namespace foreview {
namespace {

int set_policy(int policy, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), policy, &parameters);
}

}  // namespace

std::optional<std::string> enter_realtime() {
  const int error = set_policy(SCHED_RR, sched_get_priority_min(SCHED_RR));
  if (error == 0) return std::nullopt;
  return std::generic_category().message(error);
}

OrdinaryPriority::OrdinaryPriority() : policy_(SCHED_OTHER), priority_(0) {
  sched_param parameters{};
  int policy = SCHED_OTHER;
  if (pthread_getschedparam(pthread_self(), &policy, &parameters) != 0 || policy == SCHED_OTHER) return;
  policy_ = policy;
  priority_ = parameters.sched_priority;
  set_policy(SCHED_OTHER, 0);
}

OrdinaryPriority::~OrdinaryPriority() {
  // Cannot be refused for want of rights unless they were taken away meanwhile; then it stays an ordinary thread.
  if (policy_ != SCHED_OTHER) set_policy(policy_, priority_);
}

}  // namespace foreview
