// SPDX-License-Identifier: BSD-3-Clause
// weft accumulate --resume: killed at any moment and started again it comes to the same bytes;
// states that do not fit are refused and stay as they are; halves can be joined; the mean so far is
// written on request. WEFT_KILLS=N kills N times instead of a few.
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sched.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>
#include <xxhash.h>

#include "tests/support/command.h"
#include "weft.h"

enum { FILES = 6, FRAMES = 240, WIDTH = 160, HEIGHT = 120, CHANNELS = 4 };
enum { MAX_ARGUMENTS = 24 };

static struct command_result result;

// ---- frames and files ---------------------------------------------------------------------------

static uint32_t next_random(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

// Half floats from 0 to 1: any method takes them.
static void make_frame(const char *path, uint32_t seed)
{
    static float plane[CHANNELS][WIDTH * HEIGHT];
    static const char *const names[CHANNELS] = {"A", "B", "G", "R"};
    struct weft_image_channel channel[CHANNELS] = {{.sampling = {0, 0}}};
    for (int c = 0; c < CHANNELS; c++) {
        snprintf(channel[c].name, sizeof channel[c].name, "%s", names[c]);
        channel[c].type = WEFT_PIXEL_HALF;
        channel[c].plane = plane[c];
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            plane[c][i] = (float)(next_random(&seed) >> 8) * 0x1p-24f;
    }
    const struct weft_image image = {
        .width = WIDTH, .height = HEIGHT, .channel_count = CHANNELS, .channels = channel};
    assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = path)), WEFT_OK);
}

static bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

static void assert_same_file(const char *a, const char *b)
{
    size_t size_a, size_b;
    char *of_a = command_read_file(a, &size_a), *of_b = command_read_file(b, &size_b);
    if (size_a != size_b || memcmp(of_a, of_b, size_a) != 0)
        fail_msg("%s (%zu bytes) and %s (%zu bytes) differ", a, size_a, b, size_b);
    free(of_a);
    free(of_b);
}

static void copy_file(const char *from, const char *to)
{
    size_t size;
    char *bytes = command_read_file(from, &size);
    command_write_file(to, bytes, size);
    free(bytes);
}

static void remove_all(const char *const *paths)
{
    for (; *paths; paths++)
        unlink(*paths);
}

// Files that only a run that was cut short could have left.
static int count_hidden(void)
{
    int count = 0;
    DIR *dir = opendir(".");
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        count += entry->d_name[0] == '.' && strcmp(entry->d_name, ".") != 0 &&
                 strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return count;
}

// Many names for a few files, and what one run makes of them by each method.
static const struct method {
    const char *name, *output, *error; // error: of the standard error; NULL: there is none
    const char *options[8];
} methods[] = {
    {"exact", "exact.exr", "exact_error.exr", {"--stderr", "NEW_ERROR"}},
    {"tree", "tree.exr", NULL, {"--method", "tree", "--emulate"}},
    {"weighted tree",
     "tree16.exr",
     NULL,
     {"--method", "tree", "--emulate", "--bits", "16", "--weights", "tent"}},
    {"buffer", "buffer.exr", NULL, {"--method", "buffer"}},
    {"blend", "blend.exr", NULL, {"--method", "blend", "--emulate", "--bits", "16"}},
    {"float",
     "float.exr",
     "float_error.exr",
     {"--method", "float", "--emulate", "--stderr", "NEW_ERROR"}},
    {"weighted", "weighted.exr", NULL, {"--weights", "gauss"}},
};
enum { METHODS = sizeof methods / sizeof *methods };

// "weft accumulate l_%04d.exr -o OUT ..." with more up to NULL; names of the standard error's file
// for NEW_ERROR.
static void make_command(const char *argv[MAX_ARGUMENTS], const struct method *m, const char *out,
                         const char *error, const char *const *more)
{
    int argc = 0;
    argv[argc++] = "weft";
    argv[argc++] = "accumulate";
    argv[argc++] = "l_%04d.exr";
    argv[argc++] = "-o";
    argv[argc++] = out;
    for (int i = 0; i < 8 && m->options[i]; i++)
        argv[argc++] = strcmp(m->options[i], "NEW_ERROR") == 0 ? error : m->options[i];
    for (; *more; more++) {
        assert_true(argc < MAX_ARGUMENTS - 1);
        argv[argc++] = *more;
    }
    argv[argc] = NULL;
}

static double seconds_of_a_run; // with a state

static double now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void succeed(const char *const *argv)
{
    command_run_list(&result, argv);
    if (result.code != 0)
        fail_msg("%s %s ...: code %d, %s", argv[0], argv[1], result.code, result.err);
}

static int setup(void **state)
{
    if (command_setup_folder(state) != 0)
        return -1;
    for (int i = 0; i < FILES; i++) {
        char path[32];
        snprintf(path, sizeof path, "f%d.exr", i);
        make_frame(path, 77 + (uint32_t)i);
    }
    for (int i = 0; i < FRAMES; i++) {
        char path[32], to[32];
        snprintf(to, sizeof to, "f%d.exr", i % FILES);
        snprintf(path, sizeof path, "l_%04d.exr", i);
        if (symlink(to, path) != 0)
            return -1;
    }
    for (size_t i = 0; i < METHODS; i++) {
        const char *argv[MAX_ARGUMENTS];
        make_command(argv, &methods[i], methods[i].output, methods[i].error,
                     (const char *[]){NULL});
        succeed(argv);
    }
    const char *argv[MAX_ARGUMENTS];
    make_command(argv, &methods[0], "s.exr", "e.exr",
                 (const char *[]){"--resume", "s.state", NULL});
    const double start = now_seconds();
    succeed(argv);
    seconds_of_a_run = now_seconds() - start;
    remove_all((const char *[]){"s.exr", "e.exr", "s.state", NULL});
    return 0;
}

// ---- killed and started again -------------------------------------------------------------------

static int kill_count(int normally)
{
    const char *text = getenv("WEFT_KILLS");
    return text ? atoi(text) : normally;
}

static void pause_seconds(double seconds)
{
    usleep((useconds_t)(1e6 * seconds));
}

// Starts it, sends the signal at some moment of its run, and returns whether it died of that.
static bool run_and_signal(const char *const *argv, int signal, double seconds, int err)
{
    const pid_t pid = command_start(-1, err, argv);
    int status;
    pause_seconds(seconds);
    command_signal(pid, signal, &status);
    if (!WIFSIGNALED(status) && WEXITSTATUS(status) != 0)
        fail_msg("ended with code %d", WEXITSTATUS(status));
    return WIFSIGNALED(status);
}

// Moments of a run, ever finer, whatever the machine takes for one: between `from` and `to` of it.
static double moment_of_a_run(int index, double from, double to)
{
    const double golden = 0.6180339887498949 * (index + 1);
    return seconds_of_a_run * (from + (to - from) * (golden - floor(golden)));
}

// How many frames a run that ended by itself found in the state; -1: it does not say.
static int frames_held(const char *text)
{
    int held = -1;
    const char *at = strstr(text, "s.state holds ");
    return at && (sscanf(at, "s.state holds all %d", &held) == 1 ||
                  sscanf(at, "s.state holds %d", &held) == 1)
               ? held
               : -1;
}

static void a_kill_at_any_moment_costs_nothing(void **state)
{
    (void)state;
    uint32_t seed = 5;
    int killed = 0, saved = 0;
    for (size_t i = 0; i < METHODS; i++) {
        const struct method *m = &methods[i];
        const char *argv[MAX_ARGUMENTS];
        make_command(argv, m, "new.exr", "new_error.exr",
                     (const char *[]){"--resume", "s.state", "-v", NULL});
        for (int k = 0; k < kill_count(3); k++) {
            const double share = (double)(next_random(&seed) % 1000) / 1000.0;
            const bool died = run_and_signal(argv, SIGKILL, 0.01 + share * seconds_of_a_run, -1);
            // Either file is whole or is not there.
            killed += died;
            saved += exists("s.state");
            if (!died)
                assert_same_file("new.exr", m->output);
            if (exists("new.exr"))
                command_succeeds("info", "new.exr");
            if (k % 4 == 3 || !died)
                remove_all((const char *[]){"s.state", "new.exr", "new_error.exr", NULL});
        }
        succeed(argv);
        assert_same_file("new.exr", m->output);
        if (m->error)
            assert_same_file("new_error.exr", m->error);
        remove_all((const char *[]){"s.state", "new.exr", "new_error.exr", NULL});
    }
    assert_true(killed > 0 && saved > 0);
}

// With a state in the middle, so that the rest is read by another process.
static void a_rest_is_added_to_what_is_held(void **state)
{
    (void)state;
    for (size_t i = 0; i < METHODS; i++) {
        const struct method *m = &methods[i];
        const char *argv[MAX_ARGUMENTS];
        make_command(argv, m, "new.exr", "new_error.exr",
                     (const char *[]){"--resume", "s.state", "-v", NULL});
        int held = -1;
        for (int tries = 0; tries < 12 && (held <= 0 || held >= FRAMES); tries++) {
            remove_all((const char *[]){"s.state", "new.exr", "new_error.exr", NULL});
            run_and_signal(argv, SIGKILL, moment_of_a_run(tries, 0.2, 0.95), -1);
            if (!exists("s.state"))
                continue;
            unlink("new.exr"); // where it was too late
            succeed(argv);
            held = frames_held(result.err);
        }
        // States are saved as seldom as saving takes: quick machines may save one, at the end.
        if (held <= 0 || held >= FRAMES) {
            print_message("%s: a run is over too soon for a state in its middle\n", m->name);
            succeed(argv);
        }
        assert_same_file("new.exr", m->output);
        // All of it is there now: the same command only writes the result.
        unlink("new.exr");
        succeed(argv);
        assert_int_equal(frames_held(result.err), FRAMES);
        assert_non_null(strstr(result.err, "only the result is written"));
        assert_same_file("new.exr", m->output);
        if (m->error)
            assert_same_file("new_error.exr", m->error);
        remove_all((const char *[]){"s.state", "new.exr", "new_error.exr", NULL});
    }
}

// ---- signals ------------------------------------------------------------------------------------

static char *read_text(const char *path)
{
    size_t size;
    char *text = command_read_file(path, &size);
    text[size] = 0;
    return text;
}

static void interrupts_write_nothing_and_say_how_far_it_came(void **state)
{
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    int ended = 0, with_state = 0;
    for (int i = 0; i < 9 || (i < 45 && !(ended > 0 && with_state > 0)); i++) {
        const char *argv[MAX_ARGUMENTS];
        const bool resumes = i % 3 != 1;
        make_command(argv, &methods[0], "new.exr", "new_error.exr",
                     resumes ? (const char *[]){"--resume", "s.state", NULL}
                             : (const char *[]){NULL});
        const int before = command_folder_size();
        const int err = open("messages", O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        if (run_and_signal(argv, signals[i % 3], moment_of_a_run(i, 0.1, 0.9), err)) {
            char *text = read_text("messages");
            const bool writing = strstr(text, "240 of 240 frames, while outputs were written");
            assert_int_equal(command_folder_size() - exists("new.exr") - exists("new_error.exr"),
                             before + 1 + exists("s.state"));
            assert_true(writing || !exists("new.exr"));
            if (strstr(text, "of 240 frames")) {
                ended++;
                assert_non_null(strstr(text, "weft: ended after "));
                with_state += exists("s.state") && strstr(text, "s.state holds ");
                assert_true(!resumes == !strstr(text, "s.state"));
            }
            free(text);
        }
        close(err);
        if (exists("s.state")) {
            succeed(argv);
            assert_same_file("new.exr", methods[0].output);
        }
        remove_all((const char *[]){"s.state", "new.exr", "new_error.exr", "messages", NULL});
    }
    assert_true(ended > 0);
    if (!with_state)
        print_message("no run was met with a state: they are over too soon\n");
}

// Waits for a file of the run; false: the run has ended before.
static bool wait_for_file(const char *path, pid_t pid)
{
    int status;
    for (int i = 0; i < 1000; i++, pause_seconds(0.005)) {
        if (exists(path))
            return true;
        if (waitid(P_PID, (id_t)pid, &(siginfo_t){.si_pid = 0}, WEXITED | WNOHANG | WNOWAIT) != 0)
            return false;
        siginfo_t info = {.si_pid = 0};
        waitid(P_PID, (id_t)pid, &info, WEXITED | WNOHANG | WNOWAIT);
        if (info.si_pid == pid)
            return false;
    }
    (void)status;
    return false;
}

static void a_request_writes_the_mean_so_far(void **state)
{
    (void)state;
    int written = 0;
    for (int i = 0; i < 4 || (i < 100 && !written); i++) {
        const char *argv[MAX_ARGUMENTS];
        make_command(argv, &methods[0], "new.exr", "new_error.exr",
                     (const char *[]){"--preview", "new.png", i % 2 ? "--no-clobber" : NULL, NULL});
        const int err = open("messages", O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        const pid_t pid = command_start(-1, err, argv);
        int status;
        pause_seconds(moment_of_a_run(i, 0.2, 0.8));
        kill(pid, SIGUSR1);
        if (wait_for_file("new.png", pid)) {
            command_succeeds("info", "new.exr");
            char *text = read_text("messages");
            written += strstr(text, "its mean is written") != NULL;
            free(text);
        }
        kill(pid, SIGUSR1);
        assert_int_equal(waitpid(pid, &status, 0), pid);
        if (status != 0)
            fail_msg("status %x: %s", (unsigned)status, read_text("messages"));
        close(err);
        assert_same_file("new.exr", methods[0].output);
        assert_same_file("new_error.exr", methods[0].error);
        remove_all((const char *[]){"new.exr", "new_error.exr", "new.png", "messages", NULL});
    }
    assert_true(written > 0);
}

static void every_so_often_the_mean_is_written(void **state)
{
    (void)state;
    const char *argv[MAX_ARGUMENTS];
    make_command(argv, &methods[0], "new.exr", "new_error.exr",
                 (const char *[]){"--every", "0.02", NULL});
    const pid_t pid = command_start(-1, -1, argv);
    struct stat st;
    ino_t last = 0;
    int status, replaced = 0;
    while (waitpid(pid, &status, WNOHANG) == 0) {
        if (stat("new.exr", &st) == 0 && st.st_ino != last) {
            last = st.st_ino;
            replaced++;
        }
        pause_seconds(0.001);
    }
    assert_int_equal(status, 0);
    if (replaced < 3)
        fail_msg("the mean was written %d times", replaced);
    assert_same_file("new.exr", methods[0].output);
    assert_same_file("new_error.exr", methods[0].error);
    assert_int_equal(count_hidden(), 0);
    remove_all((const char *[]){"new.exr", "new_error.exr", NULL});
    command_fails(2, "must be more than 0", "accumulate", "f0.exr", "-o", "x.exr", "--every", "0");
    command_fails(2, "must be more than 0", "accumulate", "f0.exr", "-o", "x.exr", "--every=-1");
    command_fails(2, "which /dev/stdout cannot be", "accumulate", "f0.exr", "-o", "-", "--every",
                  "1");
    command_fails(2, "--every needs -o", "accumulate", "f0.exr", "--json", "--every", "1");
}

// ---- refusals -----------------------------------------------------------------------------------

// The command fails with this line, and the state is as it was.
#define refused(code, text, ...)                                                                   \
    do {                                                                                           \
        copy_file("s.state", "before.state");                                                      \
        command_fails(code, text, "accumulate", __VA_ARGS__, "--resume", "s.state");               \
        assert_same_file("s.state", "before.state");                                               \
        unlink("before.state");                                                                    \
    } while (0)

static void other_arguments_are_refused(void **state)
{
    (void)state;
    command_succeeds("accumulate", "f0.exr", "f1.exr", "f2.exr", "-o", "x.exr", "--resume",
                     "s.state");
#define with(code, text, ...)                                                                      \
    refused(code, text, "f0.exr", "f1.exr", "f2.exr", "-o", "y.exr", __VA_ARGS__)
    with(2, "--method: auto when it was saved, and buffer now", "--method", "buffer");
    with(2, "--nonfinite: error when it was saved, and skip now", "--nonfinite", "skip");
    with(2, "--average-all: not given when it was saved, and given now", "--average-all");
    with(2, "--transfer: auto when it was saved, and linear now", "--transfer", "linear");
    with(2, "what is kept of frames: their mean when it was saved", "--stderr", "z.exr");
    with(2, "what is kept of frames: their mean when it was saved", "--until", "1e-3");
    command_write_file("weights", "1\n2\n3\n", 6);
    with(2, "f1.exr had the weight 1 and has 2 now", "--weights", "weights");
    command_write_file("weights", "0\n1\n1\n", 6);
    with(2, "f0.exr, which it holds, is not among the frames", "--weights", "weights");
#undef with
    refused(2, "f2.exr, which it holds, is not among the frames", "f0.exr", "f1.exr", "-o",
            "y.exr");
    refused(2, "f2.exr, which it holds, is not among the frames", "f0.exr", "f1.exr", "./f2.exr",
            "-o", "y.exr");
    refused(2, "f3.exr comes before f0.exr", "f3.exr", "f0.exr", "f1.exr", "f2.exr", "-o", "y.exr");
    // What decides nothing of the sums may be another.
    command_succeeds("accumulate", "f0.exr", "f1.exr", "f2.exr", "-o", "y.exr", "--resume",
                     "s.state", "--type", "float", "--compression", "none", "--threads", "1");
    command_succeeds("accumulate", "f0.exr", "f1.exr", "f2.exr", "-o", "z.exr", "--type", "float",
                     "--compression", "none");
    assert_same_file("y.exr", "z.exr");
    remove_all((const char *[]){"s.state", "x.exr", "y.exr", "z.exr", "weights", NULL});
}

static void other_files_are_refused(void **state)
{
    (void)state;
    copy_file("f0.exr", "a.exr");
    copy_file("f1.exr", "b.exr");
    command_succeeds("accumulate", "a.exr", "b.exr", "-o", "x.exr", "--resume", "s.state");
    copy_file("f1.exr", "b.exr"); // the same bytes at another time: nobody looks at them
    refused(3, "b.exr has changed since it was added", "a.exr", "b.exr", "-o", "x.exr");
    copy_file("f2.exr", "b.exr");
    refused(3, "b.exr has changed since it was added", "a.exr", "b.exr", "-o", "x.exr");
    unlink("b.exr");
    refused(3, "b.exr, which it holds, is gone", "a.exr", "b.exr", "-o", "x.exr");
    remove_all((const char *[]){"s.state", "a.exr", "x.exr", NULL});
}

// Where members of the file are, as state_file.h has it.
enum { AT_FORMAT = 8, AT_ORDER = 12, AT_SIZE = 16, AT_CHECKSUM = 24, AT_VERSION = 32 };

static void write_state(const char *bytes, size_t size, bool right)
{
    char *copy = malloc(size + 1);
    memcpy(copy, bytes, size);
    const uint64_t checksum = XXH3_64bits(copy + AT_VERSION, size - AT_VERSION);
    if (right)
        memcpy(copy + AT_CHECKSUM, &checksum, sizeof checksum);
    command_write_file("s.state", copy, size);
    free(copy);
}

static void damaged_states_are_refused(void **state)
{
    (void)state;
    size_t size;
    command_succeeds("accumulate", "f0.exr", "f1.exr", "-o", "x.exr", "--resume", "s.state");
    char *good = command_read_file("s.state", &size), *bytes = malloc(size + 1);
#define refused_as(code, text) refused(code, text, "f0.exr", "f1.exr", "-o", "x.exr")
    const size_t cuts[] = {0, 1, 8, 31, 32, 71, 72, 1000, size / 2, size - 1};
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; i++) {
        command_write_file("s.state", good, cuts[i]);
        refused_as(3, cuts[i] < AT_FORMAT ? "no state of weft accumulate" : "the state is cut");
    }
    uint32_t seed = 99;
    for (int i = 0; i < 24; i++) {
        memcpy(bytes, good, size);
        const size_t at = i < 12 ? AT_CHECKSUM + (size_t)i * 4 : next_random(&seed) % size;
        if (at < AT_CHECKSUM)
            continue;
        bytes[at] ^= (char)(1 << i % 8);
        command_write_file("s.state", bytes, size);
        refused_as(3, "the state is damaged: its checksum is another one");
    }
    memcpy(bytes, good, size);
    bytes[size] = 0;
    command_write_file("s.state", bytes, size + 1);
    refused_as(3, "more bytes are there than it tells");
    bytes[AT_FORMAT]++;
    write_state(bytes, size, true);
    refused_as(3, "the state is of format 2, from a newer weft");
    memcpy(bytes, good, size);
    memcpy(bytes + AT_ORDER, "\1\2\3\4", 4);
    write_state(bytes, size, true);
    refused_as(3, "of a machine with another byte order");
    memcpy(bytes, good, size);
    memcpy(bytes + AT_VERSION, "9.9.9", 6);
    write_state(bytes, size, true);
    refused_as(3, "the state is of weft 9.9.9: this is " WEFT_TEST_VERSION);
    command_write_file("s.state", "hello", 5);
    refused_as(3, "no state of weft accumulate");
    free(good);
    free(bytes);
    remove_all((const char *[]){"s.state", "x.exr", NULL});
}

// Bytes that are wrong, with a checksum that is right: no crash, and one line.
static void forged_states_are_survived(void **state)
{
    (void)state;
    size_t size;
    uint32_t seed = 7;
    int refused_count = 0;
    command_succeeds("accumulate", "f0.exr", "f1.exr", "-o", "x.exr", "--resume", "s.state");
    char *good = command_read_file("s.state", &size), *bytes = malloc(size);
    for (int i = 0; i < 36; i++) {
        memcpy(bytes, good, size);
        const size_t at = AT_VERSION + next_random(&seed) % (i < 24 ? 700 : size - AT_VERSION);
        bytes[at] = (char)next_random(&seed);
        write_state(bytes, size, true);
        command_run(&result, "weft", "accumulate", "f0.exr", "f1.exr", "-o", "x.exr", "--resume",
                    "s.state");
        if (result.code != 0 && result.code != 2 && result.code != 3)
            fail_msg("byte %zu: code %d, %s", at, result.code, result.err);
        refused_count += result.code != 0;
    }
    assert_true(refused_count > 10);
    free(good);
    free(bytes);
    remove_all((const char *[]){"s.state", "x.exr", NULL});
}

static void a_state_goes_where_it_can_be_written(void **state)
{
    (void)state;
    command_fails(4, "no.folder/s.state", "accumulate", "f0.exr", "-o", "x.exr", "--resume",
                  "no.folder/s.state");
    assert_int_equal(mkdir("s.folder", 0700), 0);
    command_fails(4, "s.folder", "accumulate", "f0.exr", "-o", "x.exr", "--resume", "s.folder");
    rmdir("s.folder");
    command_fails(2, "the same file", "accumulate", "f0.exr", "-o", "x.exr", "--resume", "x.exr");
    command_fails(2, "is the input f0.exr", "accumulate", "f0.exr", "-o", "x.exr", "--resume",
                  "f0.exr");
    command_fails(2, "must be a file", "accumulate", "f0.exr", "-o", "x.exr", "--resume",
                  "/dev/null");
}

// ---- a sequence that grows ----------------------------------------------------------------------

// "weft accumulate FRAME ... -o OUT METHOD ..." of the numbers in `frames`, with the state or
// without.
static void accumulate_some(const char *frames, const char *out, const char *const *method,
                            bool resume)
{
    static char name[8][8];
    const char *argv[MAX_ARGUMENTS] = {"weft", "accumulate"};
    int argc = 2;
    for (int i = 0; frames[i]; i++) {
        snprintf(name[i], sizeof name[i], "f%c.exr", frames[i]);
        argv[argc++] = name[i];
    }
    argv[argc++] = "-o", argv[argc++] = out;
    for (; *method; method++)
        argv[argc++] = *method;
    if (resume)
        argv[argc++] = "--resume", argv[argc++] = "s.state";
    command_run_list(&result, argv);
}

static void assert_grown(const char *before, const char *after, const char *const *method)
{
    accumulate_some(before, "x.exr", method, true);
    assert_int_equal(result.code, 0);
    accumulate_some(after, "y.exr", method, true);
    if (result.code != 0)
        fail_msg("%s after %s: %s", after, before, result.err);
    accumulate_some(after, "z.exr", method, false);
    assert_int_equal(result.code, 0);
    assert_same_file("y.exr", "z.exr");
    unlink("s.state");
}

static void assert_not_grown(const char *before, const char *after, const char *const *method,
                             const char *text)
{
    accumulate_some(before, "x.exr", method, true);
    assert_int_equal(result.code, 0);
    copy_file("s.state", "before.state");
    accumulate_some(after, "y.exr", method, true);
    if (result.code != 2 || !strstr(result.err, text))
        fail_msg("%s after %s: code %d, %s", after, before, result.code, result.err);
    assert_same_file("s.state", "before.state");
    unlink("s.state");
}

static void more_frames_may_come(void **state)
{
    (void)state;
    const char *const exact[] = {NULL}, *const tree[] = {"--method", "tree", "--emulate", NULL};
    const char *const sums[] = {"--method", "float", "--emulate", NULL};
    const char *const buffer[] = {"--method", "buffer", NULL};
    assert_grown("02", "0234", exact);
    assert_grown("024", "01234", exact); // between: the order of exact sums decides nothing
    assert_grown("01", "01234", tree);
    assert_grown("01", "01234", sums);
    assert_not_grown("12", "012", exact, "f0.exr comes before f1.exr, which it holds");
    assert_not_grown("024", "01234", tree, "f1.exr comes before f4.exr, which it holds");
    // It has other weights where all are known beforehand.
    assert_not_grown("01", "012", buffer, "frame_count is 2, here 3");
}

// A frame that could not be read is looked at again once it is another file.
static void bad_frames_may_mend(void **state)
{
    (void)state;
    command_write_file("bad.exr", "no image", 8);
#define accumulate(expected, ...)                                                                  \
    do {                                                                                           \
        command_run(&result, "weft", "accumulate", "f0.exr", "bad.exr", "f1.exr", "--skip-bad",    \
                    __VA_ARGS__);                                                                  \
        assert_int_equal(result.code, expected);                                                   \
    } while (0)
    accumulate(3, "-o", "x.exr", "--resume", "s.state");
    accumulate(3, "-o", "y.exr", "--resume", "s.state");
    assert_same_file("x.exr", "y.exr");
    refused(3, "bad.exr is neither", "f0.exr", "bad.exr", "f1.exr", "-o", "y.exr");
    copy_file("f2.exr", "bad.exr");
    accumulate(0, "-o", "y.exr", "--resume", "s.state");
    accumulate(0, "-o", "x.exr");
    assert_same_file("x.exr", "y.exr");
#undef accumulate
}

// ---- what is not averaged, and PNG --------------------------------------------------------------

// Half, float and integers: the last two are copied from the first frame, where the name says so.
static void make_layers(const char *path, uint32_t seed)
{
    enum { SIZE = 24 };
    static const char *const names[] = {"G", "Z", "id"};
    static float plane[3][SIZE * SIZE];
    static uint32_t integers[SIZE * SIZE];
    struct weft_image_channel channel[3] = {{.type = WEFT_PIXEL_HALF},
                                            {.type = WEFT_PIXEL_FLOAT},
                                            {.type = WEFT_PIXEL_UINT, .integers = integers}};
    for (int c = 0; c < 3; c++) {
        snprintf(channel[c].name, sizeof channel[c].name, "%s", names[c]);
        channel[c].plane = plane[c];
        for (int i = 0; i < SIZE * SIZE; i++)
            plane[c][i] = (float)(next_random(&seed) >> 8) * 0x1p-24f;
    }
    for (int i = 0; i < SIZE * SIZE; i++)
        integers[i] = next_random(&seed);
    const struct weft_image image = {.x = -3,
                                     .y = 5,
                                     .width = SIZE,
                                     .height = SIZE,
                                     .display_min = {-8, -8},
                                     .display_max = {40, 40},
                                     .channel_count = 3,
                                     .channels = channel};
    assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = path)), WEFT_OK);
}

static void assert_in_parts(const char *const frame[3], const char *more)
{
    const char *const option = more ? more : "--threads=1";
    command_succeeds("accumulate", frame[0], frame[1], frame[2], option, "-o", "x.exr");
    command_succeeds("accumulate", frame[0], option, "--resume", "s.state");
    command_succeeds("accumulate", frame[0], frame[1], frame[2], option, "-o", "y.exr", "--resume",
                     "s.state");
    assert_same_file("x.exr", "y.exr");
    command_succeeds("accumulate", frame[0], frame[1], frame[2], option, "-o", "y.exr", "--resume",
                     "s.state");
    assert_same_file("x.exr", "y.exr");
    command_succeeds("accumulate", frame[0], option, "--resume", "a.state");
    command_succeeds("accumulate", frame[1], frame[2], option, "--resume", "b.state");
    command_succeeds("accumulate", "a.state", "b.state", "-o", "z.exr");
    assert_same_file("x.exr", "z.exr");
    remove_all((const char *[]){"s.state", "a.state", "b.state", "x.exr", "y.exr", "z.exr", NULL});
}

static void what_is_copied_and_decoded_is_the_same(void **state)
{
    (void)state;
    const char *const layers[] = {"a.exr", "b.exr", "c.exr"};
    const char *const png[] = {"a.png", "b.png", "c.png"};
    for (int i = 0; i < 3; i++) {
        char frame[8];
        make_layers(layers[i], 1 + (uint32_t)i);
        snprintf(frame, sizeof frame, "f%d.exr", i);
        command_succeeds("accumulate", frame, "--preview", png[i]);
    }
    assert_in_parts(layers, NULL);
    assert_in_parts(layers, "--average-all");
    assert_in_parts(png, NULL);
    assert_in_parts(png, "--transfer=gamma:2.2");
    remove_all((const char *[]){"a.exr", "b.exr", "c.exr", "a.png", "b.png", "c.png", NULL});
}

// It stops where one run does, however often it was ended before.
static void until_stops_at_the_same_frame(void **state)
{
    (void)state;
#define accumulate(...)                                                                            \
    command_succeeds("accumulate", "l_%04d.exr", "--until", "0.03", "-q", __VA_ARGS__)
    accumulate("-o", "x.exr");
    for (int last = 20; last < FRAMES; last += 20) {
        char frames[16];
        snprintf(frames, sizeof frames, "0-%d", last);
        accumulate("--frames", frames, "--resume", "s.state");
    }
    for (int i = 0; i < 2; i++) {
        accumulate("-o", "y.exr", "--resume", "s.state");
        assert_same_file("x.exr", "y.exr");
        unlink("y.exr");
    }
    // It did stop, and goes on where it shall be better.
    command_run(&result, "weft", "accumulate", "l_%04d.exr", "--until", "0.02", "-v", "--resume",
                "s.state");
    const int held = frames_held(result.err);
    if (result.code != 0 || held < 60 || held > 140)
        fail_msg("code %d, held %d: %s", result.code, held, result.err);
    command_succeeds("accumulate", "l_%04d.exr", "--until", "0.02", "-q", "-o", "x.exr");
    command_succeeds("accumulate", "l_%04d.exr", "--until", "0.02", "-q", "-o", "y.exr", "--resume",
                     "s.state");
    assert_same_file("x.exr", "y.exr");
#undef accumulate
}

// ---- joining ------------------------------------------------------------------------------------

static void halves_are_joined_to_the_bytes_of_one_run(void **state)
{
    (void)state;
    command_succeeds("accumulate", "l_%04d.exr", "--frames", "0-99", "-o", "x.exr", "--stderr",
                     "y.exr", "--resume", "a.state");
    command_succeeds("accumulate", "l_%04d.exr", "--frames", "100-229", "-o", "x.exr", "--stderr",
                     "y.exr", "--resume", "b.state");
    command_succeeds("accumulate", "l_%04d.exr", "--frames", "230-239", "-o", "x.exr", "--stderr",
                     "y.exr", "--resume", "c.state");
    command_succeeds("accumulate", "a.state", "b.state", "c.state", "-o", "x.exr", "--stderr",
                     "y.exr", "--resume", "all.state");
    assert_same_file("x.exr", methods[0].output);
    assert_same_file("y.exr", methods[0].error);
    // What was joined is a state like others.
    command_succeeds("accumulate", "all.state", "-o", "z.exr");
    assert_same_file("z.exr", methods[0].output);
    command_succeeds("accumulate", "l_%04d.exr", "--frames", "0-99", "-o", "x.exr");
    command_succeeds("accumulate", "a.state", "-o", "z.exr");
    assert_same_file("z.exr", "x.exr");
    // The frames need not be there.
    assert_int_equal(rename("f0.exr", "away"), 0);
    command_succeeds("accumulate", "a.state", "b.state", "c.state", "-o", "z.exr");
    assert_same_file("z.exr", methods[0].output);
    assert_int_equal(rename("away", "f0.exr"), 0);

    command_fails(2, "l_0000.exr is in a.state and in all.state", "accumulate", "a.state",
                  "all.state", "-o", "z2.exr");
    command_fails(2, "f0.exr is none", "accumulate", "a.state", "f0.exr", "-o", "z2.exr");
    command_fails(2, "--resume b.state: it exists", "accumulate", "a.state", "-o", "z2.exr",
                  "--resume", "b.state");
    command_fails(2, "--method: the frames of states are accumulated already", "accumulate",
                  "a.state", "--method", "exact", "-o", "z2.exr");
    command_fails(2, "--weights is of frames", "accumulate", "a.state", "--weights", "tent", "-o",
                  "z2.exr");
    copy_file("a.state", "y.exr"); // a state by its content, whatever its name
    command_fails(2, "the output y.exr is the input y.exr", "accumulate", "y.exr", "-o", "y.exr");
    remove_all((const char *[]){"a.state", "b.state", "c.state", "all.state", "x.exr", "y.exr",
                                "z.exr", NULL});
}

// Floats of many magnitudes, with weights that are no integers, some below 0.
static void any_weights_are_joined(void **state)
{
    (void)state;
    const char *const frames[] = {"a.exr", "b.exr", "c.exr", "d.exr"};
    static float plane[400];
    uint32_t seed = 3;
    for (int f = 0; f < 4; f++) {
        struct weft_image_channel channel = {.name = "Y", .plane = plane};
        const struct weft_image image = {
            .width = 20, .height = 20, .channel_count = 1, .channels = &channel};
        for (int i = 0; i < 400; i++)
            plane[i] = ldexpf((float)(int32_t)next_random(&seed), -(int)(next_random(&seed) % 60));
        assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = frames[f])),
                         WEFT_OK);
    }
#define write_weights(text) command_write_file("weights", text, strlen(text))
#define accumulate(...) command_succeeds("accumulate", "--weights", "weights", __VA_ARGS__)
    write_weights("0.3\n-0.1\n1.7\n0.0123456789\n");
    accumulate("a.exr", "b.exr", "c.exr", "d.exr", "-o", "x.exr", "--stderr", "y.exr");
    write_weights("0.3\n-0.1\n");
    accumulate("a.exr", "b.exr", "--stderr", "z.exr", "--resume", "a.state");
    write_weights("1.7\n0.0123456789\n");
    accumulate("c.exr", "d.exr", "--stderr", "z.exr", "--resume", "b.state");
    command_succeeds("accumulate", "a.state", "b.state", "-o", "new.exr", "--stderr",
                     "new_error.exr");
    assert_same_file("x.exr", "new.exr");
    assert_same_file("y.exr", "new_error.exr");
#undef accumulate
#undef write_weights
    unlink("d.exr");
}

static void states_that_do_not_fit_are_not_joined(void **state)
{
    (void)state;
    command_succeeds("accumulate", "f0.exr", "f1.exr", "-o", "x.exr", "--resume", "a.state");
    command_succeeds("accumulate", "f2.exr", "-o", "x.exr", "--nonfinite", "skip", "--resume",
                     "b.state");
    command_fails(2,
                  "a.state and b.state cannot be joined: --nonfinite: error there, and skip here",
                  "accumulate", "a.state", "b.state", "-o", "y.exr");
    command_fails(2, "--stderr: a.state keeps the mean", "accumulate", "a.state", "-o", "y.exr",
                  "--stderr", "z.exr");
    unlink("b.state");
    command_succeeds("accumulate", "f2.exr", "-o", "x.exr", "--stderr", "z.exr", "--resume",
                     "b.state");
    command_fails(2, "cannot be joined: what is kept of frames", "accumulate", "a.state", "b.state",
                  "-o", "y.exr");
    unlink("b.state");
    for (int i = 0; i < 2; i++) {
        const char *name = i ? "b.state" : "c.state", *frame = i ? "f2.exr" : "f3.exr";
        command_succeeds("accumulate", frame, "-o", "x.exr", "--method", "tree", "--emulate",
                         "--resume", name);
    }
    command_fails(2, "accumulate: tree cannot be joined", "accumulate", "b.state", "c.state", "-o",
                  "y.exr");
}

// ---- disks that are full ------------------------------------------------------------------------

// The mean is not lost where the state cannot be saved, and what was saved before stays.
static void a_full_disk_is_told(void **state)
{
    (void)state;
    assert_int_equal(mkdir("full", 0700), 0);
    if (unshare(geteuid() == 0 ? CLONE_NEWNS : CLONE_NEWUSER | CLONE_NEWNS) != 0 ||
        mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0 ||
        mount("weft-test", "full", "tmpfs", 0, "size=256k,mode=777") != 0) {
        print_message("no file system can be mounted here: %s\n", strerror(errno));
        rmdir("full");
        skip();
    }
    command_run(&result, "weft", "accumulate", "l_%04d.exr", "-o", "x.exr", "--stderr", "y.exr",
                "--resume", "full/s.state");
    assert_int_equal(result.code, 4);
    assert_non_null(strstr(result.err, "No space left on device"));
    assert_same_file("x.exr", methods[0].output);
    assert_false(exists("full/s.state"));
    assert_int_equal(umount("full"), 0);
    if (mount("weft-test", "full", "tmpfs", MS_RDONLY, "size=64k") == 0) {
        command_fails(4, "full/s.state", "accumulate", "f0.exr", "-o", "z.exr", "--resume",
                      "full/s.state");
        umount("full");
    }
    remove_all((const char *[]){"x.exr", "y.exr", NULL});
    rmdir("full");
}

// What a test that failed left.
static int clean_up(void **state)
{
    (void)state;
    remove_all((const char *[]){
        "s.state",  "before.state", "a.state", "b.state", "c.state",       "all.state",
        "x.exr",    "y.exr",        "z.exr",   "new.exr", "new_error.exr", "new.png",
        "messages", "a.exr",        "b.exr",   "c.exr",   "a.png",         "b.png",
        "c.png",    "bad.exr",      "weights", NULL});
    rename("away", "f0.exr");
    return 0;
}

#define TEST(f) cmocka_unit_test_teardown(f, clean_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_kill_at_any_moment_costs_nothing),
        TEST(a_rest_is_added_to_what_is_held),
        TEST(interrupts_write_nothing_and_say_how_far_it_came),
        TEST(a_request_writes_the_mean_so_far),
        TEST(every_so_often_the_mean_is_written),
        TEST(other_arguments_are_refused),
        TEST(other_files_are_refused),
        TEST(damaged_states_are_refused),
        TEST(forged_states_are_survived),
        TEST(a_state_goes_where_it_can_be_written),
        TEST(more_frames_may_come),
        TEST(bad_frames_may_mend),
        TEST(what_is_copied_and_decoded_is_the_same),
        TEST(until_stops_at_the_same_frame),
        TEST(halves_are_joined_to_the_bytes_of_one_run),
        TEST(any_weights_are_joined),
        TEST(states_that_do_not_fit_are_not_joined),
        TEST(a_full_disk_is_told),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
