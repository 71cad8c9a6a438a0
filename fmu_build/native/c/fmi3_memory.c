/* Memory: in FMI 3.0 the host hands over no functions for it. Linux and macOS: those of the process, found at loading, no library
 * named (macOS: the system's own). Windows: those of the kernel. No C runtime is brought along or asked for by name. */

#if defined(_WIN32)
__declspec(dllimport) void *__stdcall GetProcessHeap(void);
__declspec(dllimport) void *__stdcall HeapAlloc(void *, unsigned long, size_t);
__declspec(dllimport) int __stdcall HeapFree(void *, unsigned long, void *);
static void *take(size_t n, size_t size) { return HeapAlloc(GetProcessHeap(), 8 /* HEAP_ZERO_MEMORY */, n * size); }
static void give(void *memory) { HeapFree(GetProcessHeap(), 0, memory); }
#else
void *calloc(size_t, size_t);
void free(void *);
static void *take(size_t n, size_t size) { return calloc(n, size); }
static void give(void *memory) { free(memory); }
#endif
