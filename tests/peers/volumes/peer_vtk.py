# SPDX-License-Identifier: BSD-3-Clause
"""VTK's vtkImageReslice, cubic (Keys a = -1/2, which is Catmull-Rom), as a peer."""
import peer

try:
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
    from vtkmodules.vtkImagingCore import vtkImageReslice
except ImportError as error:
    peer.skip(f"not installed ({error})")

job = peer.load()
vtkSMPTools.Initialize(job.threads)
image = vtkImageData()
image.SetDimensions(job.box.shape[::-1])
image.GetPointData().SetScalars(numpy_to_vtk(job.box.ravel()))  # borrows

axes = vtkMatrix4x4()
columns = (job.du, job.dv, np.cross(job.du, job.dv), job.origin)
for column, vector in enumerate(columns):
    for row in range(3):
        axes.SetElement(row, column, vector[row])

reslice = vtkImageReslice()
reslice.SetInputData(image)
reslice.SetResliceAxes(axes)
reslice.SetOutputSpacing(1, 1, 1)
reslice.SetOutputOrigin(0, 0, 0)
reslice.SetOutputExtent(0, job.width - 1, 0, job.height - 1, 0, 0)
reslice.SetInterpolationModeToCubic()
reslice.SetNumberOfThreads(job.threads)


def run():
    reslice.Modified()
    reslice.Update()


def pixels():
    scalars = reslice.GetOutput().GetPointData().GetScalars()
    return vtk_to_numpy(scalars).reshape(job.height, job.width)


peer.serve(f"VTK {vtkVersion.GetVTKVersion()} ({vtkSMPTools.GetBackend()})", run, pixels)
