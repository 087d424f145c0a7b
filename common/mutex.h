// A mutex and its lock that clang's -Wthread-safety understands (Hutchins, Ballman and Sutherland, "C/C++
// Thread Safety Analysis", 2014): a member marked GUARDED_BY(mutex_) cannot be touched without the lock, a
// function marked REQUIRES(mutex_) cannot be called without it. With other compilers the marks are nothing.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#if defined(__clang__)
#define EVOGRASP_THREAD_ATTRIBUTE(x) __attribute__((x))
#else
#define EVOGRASP_THREAD_ATTRIBUTE(x)
#endif
#define GUARDED_BY(x) EVOGRASP_THREAD_ATTRIBUTE(guarded_by(x))
#define PT_GUARDED_BY(x) EVOGRASP_THREAD_ATTRIBUTE(pt_guarded_by(x))
#define REQUIRES(...) EVOGRASP_THREAD_ATTRIBUTE(requires_capability(__VA_ARGS__))

namespace evograsp {

class EVOGRASP_THREAD_ATTRIBUTE(capability("mutex")) Mutex {
 public:
  void lock() EVOGRASP_THREAD_ATTRIBUTE(acquire_capability()) { mutex_.lock(); }
  void unlock() EVOGRASP_THREAD_ATTRIBUTE(release_capability()) { mutex_.unlock(); }

 private:
  friend class MutexLock;
  std::mutex mutex_;
};

// Holds a mutex while it lives, but between unlock() and lock(). Waits are loops of the caller's:
//   while (queue_.empty()) lock.wait(wake_);
class EVOGRASP_THREAD_ATTRIBUTE(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) EVOGRASP_THREAD_ATTRIBUTE(acquire_capability(mutex))
      : lock_(mutex.mutex_) {}
  ~MutexLock() EVOGRASP_THREAD_ATTRIBUTE(release_capability()) {}
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  void lock() EVOGRASP_THREAD_ATTRIBUTE(acquire_capability()) { lock_.lock(); }
  void unlock() EVOGRASP_THREAD_ATTRIBUTE(release_capability()) { lock_.unlock(); }
  void wait(std::condition_variable& condition) { condition.wait(lock_); }
  // False when `end` has passed.
  template <class Clock, class Duration>
  bool wait_until(std::condition_variable& condition, std::chrono::time_point<Clock, Duration> end) {
    return condition.wait_until(lock_, end) == std::cv_status::no_timeout;
  }

 private:
  std::unique_lock<std::mutex> lock_;
};

}  // namespace evograsp
