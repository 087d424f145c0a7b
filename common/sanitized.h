// Defines EVOGRASP_SANITIZED when AddressSanitizer or ThreadSanitizer watches, whichever compiler. They
// reserve terabytes of address space, and resident memory is mostly theirs.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EVOGRASP_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define EVOGRASP_SANITIZED
#endif
#endif
