// The only file that includes libseccomp.
#include "server/decoder/confine_process.h"

#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

namespace geodesic::server {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kConfines = false;
#else
constexpr bool kConfines = true;
#endif

// The address space of this process in bytes; 0 if it cannot be told.
std::uint64_t mapped_bytes() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/self/statm", "r"),
                                                             std::fclose);
  unsigned long pages = 0;
  if (!file || std::fscanf(file.get(), "%lu", &pages) != 1) return 0;
  return std::uint64_t{pages} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

bool limit(decltype(RLIMIT_AS) what, std::uint64_t most) {
  const rlimit both{most, most};
  return ::setrlimit(what, &both) == 0;
}

bool limit_resources(const ProcessLimits& limits) {
  const std::uint64_t mapped = mapped_bytes();
  // Writing to a memory file takes none of the address space, so files have a limit too.
  return mapped != 0 && limit(RLIMIT_AS, mapped + limits.memory_bytes) &&
         limit(RLIMIT_FSIZE, limits.memory_bytes) && limit(RLIMIT_CPU, limits.cpu_seconds) &&
         limit(RLIMIT_CORE, 0);
}

bool allow(scmp_filter_ctx filter, int call) {
  return seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, 0, nullptr) == 0;
}

// Only where the third argument, a memory protection, has no right to execute.
bool allow_data_only(scmp_filter_ctx filter, int call) {
  // Without the library's macros, which are C.
  const scmp_arg_cmp third{2, SCMP_CMP_MASKED_EQ, PROT_EXEC, 0};
  return seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, 1, &third) == 0;
}

bool allow_computing(scmp_filter_ctx filter) {
  for (const int call :
       {SCMP_SYS(read), SCMP_SYS(write), SCMP_SYS(sendmsg), SCMP_SYS(close), SCMP_SYS(ftruncate),
        SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(brk), SCMP_SYS(futex),
        SCMP_SYS(sched_yield), SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom),
        SCMP_SYS(rt_sigreturn), SCMP_SYS(exit), SCMP_SYS(exit_group)}) {
    if (!allow(filter, call)) return false;
  }
  return allow_data_only(filter, SCMP_SYS(mmap)) && allow_data_only(filter, SCMP_SYS(mprotect));
}

}  // namespace

Confinement::Confinement() : filter_(kConfines ? seccomp_init(SCMP_ACT_KILL_PROCESS) : nullptr) {
  if (filter_ == nullptr || allow_computing(filter_)) return;
  seccomp_release(filter_);
  filter_ = nullptr;
}

Confinement::~Confinement() {
  if (filter_ != nullptr) seccomp_release(filter_);
}

bool Confinement::enter(const ProcessLimits& limits) const {
  if (!kConfines) return true;
  return filter_ != nullptr && limit_resources(limits) && ::prctl(PR_SET_DUMPABLE, 0) == 0 &&
         seccomp_load(filter_) == 0;
}

bool Confinement::can_confine() { return kConfines; }

}  // namespace geodesic::server
