// What the process, or a part of it, may hold in memory: taken from an account before it is
// allocated.
#ifndef CAGEFIT_SERVER_SESSION_MEMORY_ACCOUNT_H_
#define CAGEFIT_SERVER_SESSION_MEMORY_ACCOUNT_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"

namespace cagefit::server {

// Thread-safe.
class MemoryAccount {
 public:
  // Called with bytes that were taken, by the thread that will allocate them.
  using TakenFn = std::function<void(int64_t)>;

  // `name` says what is counted, for errors. `parent` counts it, too, and must outlive the account.
  MemoryAccount(std::string name, int64_t limit, MemoryAccount* parent = nullptr)
      : name_(std::move(name)), limit_(limit), parent_(parent) {}
  MemoryAccount(std::string name, int64_t limit, TakenFn taken)
      : name_(std::move(name)), limit_(limit), taken_fn_(std::move(taken)) {}
  MemoryAccount(const MemoryAccount&) = delete;
  MemoryAccount& operator=(const MemoryAccount&) = delete;

  // RESOURCE_EXHAUSTED, naming the account and its limit, without room here or in a parent; with a
  // retry time unless the limit itself is too small.
  absl::Status Take(int64_t bytes);
  void Give(int64_t bytes);

  int64_t taken() const { return taken_; }
  int64_t limit() const { return limit_; }

 private:
  const std::string name_;
  const int64_t limit_;
  MemoryAccount* const parent_ = nullptr;
  const TakenFn taken_fn_;
  std::atomic<int64_t> taken_{0};
};

// A part of an account, given back when it is destroyed.
class MemoryReservation {
 public:
  explicit MemoryReservation(MemoryAccount* account) : account_(account) {}
  MemoryReservation(MemoryReservation&& other) noexcept
      : account_(other.account_), bytes_(std::exchange(other.bytes_, 0)) {}
  MemoryReservation& operator=(MemoryReservation&& other) noexcept {
    std::swap(account_, other.account_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MemoryReservation() { account_->Give(bytes_); }

  // By so much more. As Take; on an error nothing changes.
  absl::Status Grow(int64_t bytes);
  // To no more than that.
  void ShrinkTo(int64_t bytes);
  int64_t bytes() const { return bytes_; }

 private:
  MemoryAccount* account_;
  int64_t bytes_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_MEMORY_ACCOUNT_H_
