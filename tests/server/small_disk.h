// A small file system in memory that a test may fill or make read-only, in a mount namespace of this process:
// nobody else sees it, and it goes with the process. Root may, and so may everybody where user namespaces are
// allowed.
#pragma once

#include <sched.h>
#include <sys/mount.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace evograsp::testing {

// Makes mounting possible for this process. Before it has other threads; once.
inline bool own_mounts() {
  static const bool may = [] {
    const auto user = ::getuid();
    const auto group = ::getgid();
    if (::unshare(CLONE_NEWNS) != 0) {
      if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
      std::ofstream("/proc/self/setgroups") << "deny";
      std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
      std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
    }
    return ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  }();
  return may;
}

class SmallDisk {
 public:
  // On an empty folder.
  SmallDisk(std::filesystem::path folder, const std::string& size)
      : folder_(std::move(folder)), size_("size=" + size) {
    mounted_ = own_mounts() && ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, size_.c_str()) == 0;
    if (!mounted_)
      std::printf(
          "CANNOT RUN HERE: disks that are full or read-only need the right to mount (root, or user "
          "namespaces)\n");
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }
  const std::filesystem::path& path() const { return folder_; }

  bool grow(const std::string& size) { return remount(0, "size=" + size); }
  // No room for another page, until grow() or restore().
  bool fill() {
    for (int attempt = 0; attempt < 20; ++attempt) {  // a file may grow between the two calls
      struct statvfs now {};
      if (::statvfs(folder_.c_str(), &now) != 0) return false;
      const std::uint64_t used = (now.f_blocks - now.f_bfree) * now.f_bsize;
      if (remount(0, "size=" + std::to_string(used))) return true;
    }
    return false;
  }
  bool make_read_only() { return remount(MS_RDONLY, size_); }
  bool restore() { return remount(0, size_); }

 private:
  bool remount(unsigned long flags, const std::string& options) {
    return ::mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT | flags, options.c_str()) == 0;
  }

  const std::filesystem::path folder_;
  const std::string size_;
  bool mounted_ = false;
};

}  // namespace evograsp::testing
