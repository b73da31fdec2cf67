// SPDX-License-Identifier: BSD-3-Clause
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "passes/gl/program.h"
#include "passes/gl/target.h"

extern char **environ;

enum { TRIAL_SECONDS = 60 }; // a compiler's worst on a loaded machine, and more

// Address space that is left to what is drawn after a trial: 128 MiB, and the 64 MiB that malloc
// reserves for each thread, of which Mesa starts one for a processor, to 32, and two more.
static size_t spare_bytes(void)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    return ((size_t)128 + 64 * (size_t)(processors < 1    ? 3
                                        : processors > 32 ? 34
                                                          : processors + 2))
           << 20;
}

// Variables by which users choose and change drivers, and such of them as cannot do harm.
static const char *const read_by_mesa[] = {"GALLIUM_", "GALLIVM_", "MESA_", "LIBGL_",
                                           "LP_",      "EGL_",     "ST_",   "__EGL_"};
static const char *const harmless[] = {"LP_NUM_THREADS=", "MESA_SHADER_CACHE_"};

static bool starts_with_any(const char *text, const char *const *prefixes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (strncmp(text, prefixes[i], strlen(prefixes[i])) == 0)
            return true;
    return false;
}

// The variables, for messages; false where there are none.
static bool list_variables(char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (char **variable = environ; variable && *variable; variable++) {
        if (!starts_with_any(*variable, read_by_mesa, WEFT_COUNT(read_by_mesa)) ||
            starts_with_any(*variable, harmless, WEFT_COUNT(harmless)))
            continue;
        if (used < size)
            used +=
                (size_t)snprintf(text + used, size - used, "%s%.64s", used ? " " : "", *variable);
    }
    return used > 0;
}

bool weft_context_trial_reason(char *text, size_t size)
{
    struct rlimit limit;
    if (list_variables(text, size))
        return true;
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return false;
    snprintf(text, size, "an address space of %llu MiB", (unsigned long long)limit.rlim_cur >> 20);
    return true;
}

// ---- in the child -------------------------------------------------------------------------------

// One texel through a buffer, a shader and a float target, as everything in weft goes.
static bool draw(struct weft_context *context, char *why, size_t why_size)
{
    static const char fragment[] = "uniform samplerBuffer source;\n"
                                   "out float value;\n"
                                   "void main() { value = 0.5 * texelFetch(source, 0).r; }\n";
    const GladGLContext *gl = &context->gl;
    struct weft_gl_buffer source;
    const float given = 3.0f;
    float pixel = 0.0f;
    struct weft_gl_target target;
    GLuint program = 0;
    if (weft_program_get(context, "trial", "", weft_shader_full_target, fragment, &program) !=
            WEFT_OK ||
        weft_gl_buffer_create(NULL, gl, GL_R32F, 1, &source) != WEFT_OK) {
        snprintf(why, why_size, "a simple shader does not compile");
        return false;
    }
    gl->BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof given, &given);
    gl->UseProgram(program);
    if (weft_gl_target_create(NULL, gl, GL_R32F, 1, 1, &target) == WEFT_OK) {
        weft_gl_target_bind(gl, &target, 1, 1);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
        weft_gl_target_read(
            NULL, gl, &target,
            &(struct weft_gl_pixels){.width = 1, .height = 1, .type = GL_FLOAT, .data = &pixel});
        if (pixel == 0.5f * given)
            return true;
    }
    snprintf(why, why_size, "it does not draw what it should");
    return false;
}

static void try_in_child(const struct weft_context_backend *backend, int verdict)
{
    char why[200] = "";
    // A driver's own words and core would be one line too many; handlers are the caller's.
    const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (int fd = 0; fd <= STDERR_FILENO && null >= 0; fd++)
        dup2(null, fd);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_UNBLOCK, &all, NULL);
    for (int number = 1; number < NSIG; number++)
        signal(number, SIG_DFL);
    alarm(TRIAL_SECONDS);
    if (mmap(NULL, spare_bytes(), PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0) ==
        MAP_FAILED)
        snprintf(why, sizeof why, "too little address space");

    struct weft_context *context = calloc(1, sizeof *context);
    if (!context) {
        snprintf(why, sizeof why, "out of memory");
    } else if (!why[0]) {
        context->backend = backend;
        if (weft_context_start(context, why, sizeof why) &&
            weft_context_enter(context) == WEFT_OK && draw(context, why, sizeof why))
            why[0] = '\0';
    }
    // The first byte tells an answer from an end without one.
    if (write(verdict, "=", 1) == 1 && write(verdict, why, strlen(why)) >= 0)
        _exit(0);
    _exit(1);
}

// ---- in the parent ------------------------------------------------------------------------------

static size_t read_verdict(int fd, char *text, size_t size)
{
    size_t used = 0;
    while (used < size - 1) {
        const ssize_t got = read(fd, text + used, size - 1 - used);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            break;
        used += (size_t)got;
    }
    text[used] = '\0';
    return used;
}

static int wait_for(pid_t child)
{
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return 0; // the caller ignores SIGCHLD: how it ended is not to be had
    return status;
}

bool weft_context_trial(const struct weft_context_backend *backend, char *why, size_t why_size)
{
    char reason[200], verdict[200];
    int ends[2];
    if (weft_library_loaded(backend->library, NULL) ||
        !weft_context_trial_reason(reason, sizeof reason))
        return true;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return true;
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        try_in_child(backend, ends[1]);
    }
    close(ends[1]);
    const size_t length = child > 0 ? read_verdict(ends[0], verdict, sizeof verdict) : 0;
    close(ends[0]);
    if (child < 0)
        return true;
    const int status = wait_for(child);
    if (length == 1)
        return true;
    if (length > 1)
        snprintf(why, why_size, "%s", verdict + 1);
    else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
        snprintf(why, why_size, "no answer within %d s", TRIAL_SECONDS);
    else
        snprintf(why, why_size, "a trial ended with %s",
                 WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "no answer");
    return false;
}
