// SPDX-License-Identifier: BSD-3-Clause
// Teem's gage as a peer: gageProbe with the kernel cubic:0,0.5 (Catmull-Rom), a context per thread.
#include <teem/gage.h>

#include "tests/peers/volumes/peer.h"

struct state {
    struct peer_job job;
    gageContext *context[PEER_MAX_THREADS];
    const double *answer[PEER_MAX_THREADS], *gradient[PEER_MAX_THREADS], *hessian[PEER_MAX_THREADS];
};

static void put_derivatives(const struct state *s, int thread, bool outside, float *out)
{
    static const int entry[6] = {0, 1, 2, 4, 5, 8};
    const size_t plane = (size_t)s->job.width * (size_t)s->job.height;
    for (int i = 0; i < 3; i++)
        out[(size_t)(1 + i) * plane] = outside ? 0.0f : (float)s->gradient[thread][i];
    for (int i = 0; i < 6; i++)
        out[(size_t)(4 + i) * plane] = outside ? 0.0f : (float)s->hessian[thread][entry[i]];
}

// gage keeps the taps of the last voxel, so neighbouring pixels share them.
static void row(void *priv, int thread, int y)
{
    struct state *s = priv;
    const struct peer_job *job = &s->job;
    float *out = job->pixels + (size_t)y * (size_t)job->width;
    for (int x = 0; x < job->width; x++) {
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = job->origin[a] + x * job->du[a] + y * job->dv[a];
        bool outside = gageProbe(s->context[thread], p[0], p[1], p[2]) != 0;
        out[x] = outside ? 0.0f : (float)*s->answer[thread];
        if (job->outputs > 1)
            put_derivatives(s, thread, outside, out + x);
    }
}

static void run(void *priv)
{
    struct state *s = priv;
    peer_rows(&s->job, row, s);
}

static bool prepare(struct state *s, Nrrd *nrrd)
{
    const struct peer_job *job = &s->job;
    const double cubic[3] = {1.0, 0.0, 0.5}; // scale, B, C
    if (nrrdWrap_va(nrrd, job->box, nrrdTypeFloat, 3, (size_t)job->size[0], (size_t)job->size[1],
                    (size_t)job->size[2]))
        return false;
    nrrdAxisInfoSet_va(nrrd, nrrdAxisInfoSpacing, 1.0, 1.0, 1.0);
    nrrdAxisInfoSet_va(nrrd, nrrdAxisInfoCenter, nrrdCenterNode, nrrdCenterNode, nrrdCenterNode);
    gageContext *context = gageContextNew();
    gagePerVolume *volume = context ? gagePerVolumeNew(context, nrrd, gageKindScl) : NULL;
    if (!volume || gagePerVolumeAttach(context, volume) ||
        gageKernelSet(context, gageKernel00, nrrdKernelBCCubic, cubic) ||
        gageQueryItemOn(context, volume, gageSclValue))
        return false;
    if (job->outputs > 1 && (gageKernelSet(context, gageKernel11, nrrdKernelBCCubicD, cubic) ||
                             gageKernelSet(context, gageKernel22, nrrdKernelBCCubicDD, cubic) ||
                             gageQueryItemOn(context, volume, gageSclGradVec) ||
                             gageQueryItemOn(context, volume, gageSclHessian)))
        return false;
    if (gageUpdate(context))
        return false;
    for (int i = 0; i < job->threads; i++) {
        s->context[i] = i == 0 ? context : gageContextCopy(context);
        if (!s->context[i])
            return false;
        gagePerVolume *own = s->context[i]->pvl[0];
        s->answer[i] = gageAnswerPointer(s->context[i], own, gageSclValue);
        s->gradient[i] = gageAnswerPointer(s->context[i], own, gageSclGradVec);
        s->hessian[i] = gageAnswerPointer(s->context[i], own, gageSclHessian);
    }
    return true;
}

int main(void)
{
    static struct state s;
    peer_load(&s.job);
    Nrrd *nrrd = nrrdNew();
    if (!nrrd || !prepare(&s, nrrd))
        peer_skip("gage refused the volume");
    int code = peer_serve(&s.job, "Teem " TEEM_VERSION_STRING, run, NULL, &s);
    for (int i = s.job.threads - 1; i >= 0; i--)
        gageContextNix(s.context[i]);
    nrrdNix(nrrd);
    return code;
}
