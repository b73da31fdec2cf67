// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/volumes/child.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static void become(char *const argv[], const int in[2], const int out[2])
{
    setpgid(0, 0); // a key that interrupts is for bench_peers, which then ends the others
    signal(SIGPIPE, SIG_DFL);
    if (dup2(in[0], STDIN_FILENO) >= 0 && dup2(out[1], STDOUT_FILENO) >= 0)
        execv(argv[0], argv);
    const char *reason = errno == ENOENT ? "skip not built or not installed\n" : "skip no start\n";
    if (write(STDOUT_FILENO, reason, strlen(reason)) < 0)
        _exit(1);
    _exit(77);
}

static bool open_pipes(int in[2], int out[2])
{
    if (pipe2(in, O_CLOEXEC) != 0)
        return false;
    if (pipe2(out, O_CLOEXEC) == 0)
        return true;
    close(in[0]);
    close(in[1]);
    return false;
}

static bool launch(struct child *child, char *const argv[])
{
    int in[2], out[2];
    if (!open_pipes(in, out))
        return false;
    child->pid = fork();
    if (child->pid == 0)
        become(argv, in, out);
    close(in[0]);
    close(out[1]);
    child->in = fdopen(in[1], "w");
    child->out = fdopen(out[0], "r");
    if (child->pid < 0)
        child->pid = 0;
    return child->pid > 0 && child->in && child->out;
}

// A program that ended may have told why, so a failed write is not the end.
static bool ask(struct child *child, const char *line, char *answer, size_t size)
{
    fputs(line, child->in);
    fflush(child->in);
    if (!fgets(answer, (int)size, child->out))
        return false;
    answer[strcspn(answer, "\n")] = '\0';
    return true;
}

static bool gone(struct child *child)
{
    child_stop(child, true);
    snprintf(child->text, sizeof child->text, "ended before it answered");
    return false;
}

// Forgets the peak of the set-up; not all kernels can.
static void reset_peak(const struct child *child)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/clear_refs", (int)child->pid);
    FILE *file = fopen(path, "w");
    if (!file)
        return;
    fputs("5", file);
    fclose(file);
}

bool child_start(struct child *child, char *const argv[], const struct cut *cut, int threads)
{
    char job[1024], answer[sizeof child->text];
    const double *o = cut->origin, *u = cut->du, *v = cut->dv;
    *child = (struct child){.text = ""};
    if (!launch(child, argv))
        return gone(child);
    snprintf(job, sizeof job,
             "job %d %d %d %d %d %d %d  %.17g %.17g %.17g  %.17g %.17g %.17g  %.17g %.17g %.17g\n",
             cut->box_fd, cut->size[0], cut->size[1], cut->size[2], cut->width, cut->height,
             threads, o[0], o[1], o[2], u[0], u[1], u[2], v[0], v[1], v[2]);
    if (!ask(child, job, answer, sizeof answer))
        return gone(child);
    const bool ready = strncmp(answer, "ready ", 6) == 0, skip = strncmp(answer, "skip ", 5) == 0;
    if (!ready)
        child_stop(child, true);
    else
        reset_peak(child);
    snprintf(child->text, sizeof child->text, "%s", answer + (ready ? 6 : skip ? 5 : 0));
    return ready;
}

bool child_run(struct child *child, double *seconds, double *again)
{
    char answer[128];
    if (!ask(child, "run\n", answer, sizeof answer))
        return gone(child);
    *again = NAN;
    return sscanf(answer, "%lf %lf", seconds, again) >= 1 || gone(child);
}

bool child_pixels(struct child *child, float *pixels, size_t count)
{
    if (fputs("pixels\n", child->in) < 0 || fflush(child->in) != 0 ||
        fread(pixels, sizeof *pixels, count, child->out) != count)
        return gone(child);
    return true;
}

uint64_t child_peak_bytes(const struct child *child)
{
    char path[64], line[256];
    unsigned long long kilobytes = 0;
    snprintf(path, sizeof path, "/proc/%d/status", (int)child->pid);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file))
        sscanf(line, "VmHWM: %llu", &kilobytes);
    if (file)
        fclose(file);
    return 1024 * (uint64_t)kilobytes;
}

void child_stop(struct child *child, bool kill_it)
{
    if (child->in)
        fclose(child->in);
    if (child->out)
        fclose(child->out);
    child->in = child->out = NULL;
    if (child->pid <= 0)
        return;
    if (kill_it)
        kill(child->pid, SIGKILL);
    while (waitpid(child->pid, NULL, 0) < 0 && errno == EINTR)
        ;
    child->pid = 0;
}
