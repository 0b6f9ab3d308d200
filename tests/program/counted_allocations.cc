// SPDX-License-Identifier: Apache-2.0
#include "tests/program/counted_allocations.h"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace panelcal::test {
namespace {

std::atomic<std::int64_t> n_allocated = 0;

void* counted(void* memory) {
  ++n_allocated;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

std::int64_t n_allocations() {
  return n_allocated;
}

}  // namespace panelcal::test

// The array forms and those that do not throw end up in these.
void* operator new(std::size_t size) {
  return panelcal::test::counted(std::malloc(size == 0 ? 1 : size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  return panelcal::test::counted(std::aligned_alloc(step, (size + step - 1) / step * step));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
