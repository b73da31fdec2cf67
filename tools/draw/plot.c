// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/plot.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/common/ending.h"
#include "tools/common/paths.h"

extern char **environ;

enum format { SVG, PNG, PDF, EPS };
const char *const plot_endings[] = {".svg", ".png", ".pdf", ".eps", NULL};

// -1: its name has an ending that is none of them, or is a file's without one.
static int find_format(const char *path)
{
    const char *ending = paths_ending(path);
    if (!*ending && paths_is_special(path))
        return SVG;
    for (int i = 0; plot_endings[i]; i++)
        if (strcasecmp(ending, plot_endings[i]) == 0)
            return i;
    return -1;
}

// In memory: no folder for temporary files is asked for. NULL with errno.
static FILE *open_scratch(void)
{
    int fd = memfd_create("weft-plot", MFD_CLOEXEC);
    FILE *file = fd < 0 ? NULL : fdopen(fd, "w+");
    if (fd >= 0 && !file)
        close(fd);
    return file;
}

// As the leader of its process group, which an end by a signal takes along; no signal comes between
// the start and that knowledge. Returns 0 or an errno value.
static int start_gnuplot(char *const *argv, FILE *in, FILE *out, FILE *err, pid_t *pid)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t all, old;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, &old);
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fileno(in), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(out), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(err), STDERR_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setsigmask(&attributes, &old);
    int error = posix_spawnp(pid, argv[0], &actions, &attributes, argv, environ);
    if (!error)
        ending_set_child(*pid);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    sigprocmask(SIG_SETMASK, &old, NULL);
    return error;
}

// Returns the wait status, or -1 with errno where gnuplot cannot be started. -d: no start-up files.
static int run_gnuplot(const char *argument, FILE *in, FILE *out, FILE *err)
{
    char *argv[] = {(char *)"gnuplot", (char *)"-d", (char *)argument, NULL};
    pid_t pid;
    int error = start_gnuplot(argv, in, out, err, &pid);
    if (error) {
        errno = error;
        return -1;
    }
    siginfo_t info;
    while (waitid(P_PID, (id_t)pid, &info, WEXITED | WNOWAIT) < 0 && errno == EINTR)
        ;
    ending_set_child(0); // its number is still its own
    int status;
    return waitpid(pid, &status, 0) == pid ? status : -1;
}

// Where there is no memory this is the error told, since it is the first.
bool plot_can_draw(void)
{
    FILE *in = open_scratch(), *out = open_scratch();
    if (!in || !out)
        report_error("no memory for what gnuplot reads and writes: %s", strerror(errno));
    bool runs = in && out && run_gnuplot("--version", in, out, out) == 0;
    if (in)
        fclose(in);
    if (out)
        fclose(out);
    return runs;
}

enum exit_code plot_check(const char *option, const char *path, const char *otherwise)
{
    if (find_format(path) < 0) {
        report_error("%s %s: the name must end in .svg, .png, .pdf or .eps", option, path);
        return EXIT_CODE_USAGE;
    }
    if (paths_check_output(path, false) != WEFT_OK)
        return EXIT_CODE_OUTPUT;
    if (plot_can_draw())
        return EXIT_CODE_DONE;
    report_error("%s needs the program gnuplot (Debian package gnuplot-nox), which does not "
                 "run here; without it, %s gives the data",
                 option, otherwise);
    return EXIT_CODE_FAILED;
}

// Of all the same picture: PDF and EPS are as large as its pixels at 96 an inch, with lines and
// texts as thick and high as there.
static void set_terminal(FILE *script, enum format format, int width, int height)
{
    if (format == SVG || format == PNG)
        fprintf(script, "set terminal %s noenhanced size %d,%d font 'sans,12'\n",
                format == SVG ? "svg background 'white'" : "pngcairo", width, height);
    else
        fprintf(script,
                "set terminal %s noenhanced color size %.4fin,%.4fin font 'sans,12' fontscale 0.75 "
                "linewidth 1.5\n",
                format == PDF ? "pdfcairo" : "epscairo", width / 96.0, height / 96.0);
}

enum exit_code plot_begin(const char *path, int width, int height, struct plot *out)
{
    *out = (struct plot){.path = path, .script = open_scratch()};
    if (!out->script) {
        report_error("%s: no memory for the plot's script: %s", path, strerror(errno));
        return EXIT_CODE_FAILED;
    }
    const int format = find_format(path);
    set_terminal(out->script, format < 0 ? SVG : (enum format)format, width, height);
    fprintf(out->script, "set grid lc '#d8d8d8' lt 1 lw 0.5\nset border lc '#505050'\n"
                         "set linetype 1 lc '#0060ad' lw 2\nset linetype 2 lc '#d95f02' lw 2\n"
                         "set linetype 3 lc '#1b9e77' lw 2\nset linetype 4 lc '#7570b3' lw 2\n"
                         "set linetype 5 lc '#e7298a' lw 2\nset linetype 6 lc '#a6761d' lw 2\n"
                         "set linetype 7 lc '#666666' lw 2\nset linetype 8 lc '#66a61e' lw 2\n");
    return EXIT_CODE_DONE;
}

void plot_quote(FILE *script, const char *text)
{
    putc('\'', script);
    for (; *text; text++) {
        if (*text == '\'')
            putc('\'', script);
        putc((unsigned char)*text < 0x20 ? '?' : *text, script);
    }
    putc('\'', script);
}

// The first line that says something: gnuplot shows the command and a caret before it.
static void report_gnuplot(const char *path, FILE *err)
{
    char line[256] = "", best[256] = "it wrote no image";
    rewind(err);
    while (fgets(line, sizeof line, err)) {
        const char *colon = strstr(line, "line ");
        if (!colon)
            continue;
        snprintf(best, sizeof best, "%s", line);
        best[strcspn(best, "\n")] = 0;
        break;
    }
    report_error("%s: gnuplot failed: %s", path, best);
}

static enum exit_code save_file(const char *path, const void *data, size_t size)
{
    enum weft_result res = weft_file_save(report_log(), path, false, data, size);
    return res == WEFT_OK ? EXIT_CODE_DONE : (enum exit_code)report_finish(res);
}

static enum exit_code save(const char *path, FILE *out)
{
    long size = fseek(out, 0, SEEK_END) == 0 ? ftell(out) : -1;
    char *data = size > 0 ? malloc((size_t)size) : NULL;
    rewind(out);
    enum exit_code code = EXIT_CODE_FAILED;
    if (!data || fread(data, 1, (size_t)size, out) != (size_t)size)
        report_error("%s: the image of %ld bytes cannot be read back", path, size);
    else
        code = save_file(path, data, (size_t)size);
    free(data);
    return code;
}

// The first line sets the terminal, and the image's name comes after it.
static void copy_script(FILE *script, const char *path, FILE *out)
{
    bool first = true;
    rewind(script);
    for (int c; (c = getc(script)) != EOF;) {
        putc(c, out);
        if (c != '\n' || !first)
            continue;
        first = false;
        fputs("set output ", out);
        plot_quote(out, path);
        putc('\n', out);
    }
}

enum exit_code plot_save_script(struct plot *plot, const char *script_path)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out)
        copy_script(plot->script, plot->path, out);
    bool good = out && report_close(out);
    enum exit_code code = EXIT_CODE_FAILED;
    if (good)
        code = save_file(script_path, text, size);
    else
        report_error("%s: out of memory", script_path);
    free(text);
    return code;
}

void plot_discard(struct plot *plot)
{
    if (plot->script)
        fclose(plot->script);
    *plot = (struct plot){0};
}

enum exit_code plot_finish(struct plot *plot)
{
    enum exit_code code = EXIT_CODE_FAILED;
    FILE *out = open_scratch(), *err = open_scratch();
    if (!out || !err || fflush(plot->script) != 0 || ferror(plot->script)) {
        report_error("%s: no memory for the plot: %s", plot->path, strerror(errno));
        goto fail;
    }
    rewind(plot->script);
    int status = run_gnuplot("-", plot->script, out, err);
    const bool drawn = status == 0 && fseek(out, 0, SEEK_END) == 0 && ftell(out) > 0;
    if (drawn)
        code = save(plot->path, out);
    else
        report_gnuplot(plot->path, err);
fail:
    if (out)
        fclose(out);
    if (err)
        fclose(err);
    plot_discard(plot);
    return code;
}
