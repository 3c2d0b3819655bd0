# Copyright 2026 The flag_sim Authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Other programs that draw the same scene, each behind the same call.

A peer is a class: Peer(shot) prepares what stands still, and draw(points, normals), both (rows,
columns, 3), returns the frame's (height, width, 3) uint8 array. Its constructor raises where
the peer is not to be had.
"""
import ctypes
from pathlib import Path
import subprocess
import tempfile
from typing import NamedTuple

from flag_sim.drawing import Camera, Light, Style
from flag_sim.drawing.scene import flag_scene
from flag_sim.drawing.scene_buffers import SceneBuffers

import numpy as np


class Shot(NamedTuple):
    """What is drawn, but for the flag's place."""

    camera: Camera
    light: Light
    objects: list
    scene: SceneBuffers

    def of_points(self, attribute):
        """Return colours (n, 3), one for each point."""
        colours = np.empty((len(self.scene.positions), 3))
        for one, (points, _) in zip(self.objects, self.scene.slices):
            colours[points] = one.surface.color
        return colours


def assemble(flag, normals, camera):
    """Return the objects of the source's scene and their buffers, with a flag in them."""
    objects = flag_scene(flag, normals, camera)
    buffers = SceneBuffers(objects)
    for chunk in buffers.begin_frame(objects):
        buffers.load(chunk)
    return objects, buffers


BACKGROUND = np.array(Style().background)


class Scanline:
    """A plain C++ program, -O3, in the source's manner."""

    name = 'C++ -O3'

    def __init__(self, shot):
        source = Path(__file__).with_name('scanline.cpp')
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder, 'scanline.so')
            subprocess.run(['g++', '-O3', '-march=native', '-shared', '-fPIC', source,
                            '-o', library], check=True)
            self._draw = ctypes.CDLL(str(library)).draw
        camera, light, _, scene = self._shot = shot
        self._matrix = np.ascontiguousarray(camera.P @ camera.pose)
        self._light = np.array([*light.direction, light.intensity, light.ambient])
        self._colours = shot.of_points('color')[scene.triangles[:, 0]]
        self._background = BACKGROUND.astype(np.uint8)
        self._points, self._normals = scene.positions.copy(), scene.normals.copy()
        self._rgb = np.empty((camera.height, camera.width, 3), np.uint8)

    def draw(self, points, normals):
        camera, _, _, scene = self._shot
        count = points.size // 3
        self._points[:count], self._normals[:count] = points.reshape(-1, 3), normals.reshape(-1, 3)

        def pointer(array):
            return array.ctypes.data_as(ctypes.c_void_p)

        self._draw(pointer(self._points), pointer(self._normals), len(self._points),
                   pointer(scene.triangles), pointer(self._colours), len(scene.triangles),
                   pointer(self._matrix), pointer(self._light), pointer(self._background),
                   camera.width, camera.height, pointer(self._rgb))
        return self._rgb


class Llvmpipe:
    """Mesa's software driver, through moderngl."""

    name = 'llvmpipe'
    VERTEX = """
        #version 330
        uniform mat4 matrix;
        uniform vec3 sun;
        uniform vec2 light;
        in vec3 point, normal, color;
        out vec3 front, back;
        void main() {
            gl_Position = matrix * vec4(point, 1.0);
            float cosine = dot(normalize(normal), sun);
            front = color * (light.y + light.x * max(cosine, 0.0));
            back = color * (light.y + light.x * max(-cosine, 0.0));
        }"""
    FRAGMENT = """
        #version 330
        in vec3 front, back;
        out vec3 color;
        void main() { color = gl_FrontFacing ? front : back; }"""

    def __init__(self, shot):
        import moderngl
        camera, light, _, scene = shot
        context = self._context = moderngl.create_context(standalone=True, backend='egl')
        if 'llvmpipe' not in context.info['GL_RENDERER']:
            raise RuntimeError(f'the driver is {context.info["GL_RENDERER"]}')
        program = context.program(vertex_shader=self.VERTEX, fragment_shader=self.FRAGMENT)
        projection = np.zeros((4, 4))
        projection[0, 0] = 2.0 * camera.focal / camera.width
        projection[1, 1] = -2.0 * camera.focal / camera.height
        projection[2, 2:] = 1.0, -2.0 * camera.near
        projection[3, 2] = 1.0
        program['matrix'].write((projection @ camera.pose).T.astype(np.float32).tobytes())
        program['sun'] = light.direction
        program['light'] = light.intensity, light.ambient
        self._data = np.column_stack([scene.positions, scene.normals]).astype(np.float32)
        self._buffer = context.buffer(self._data.tobytes())
        colours = context.buffer((shot.of_points('color') / 255).astype(np.float32).tobytes())
        self._arrays = context.vertex_array(
            program, [(self._buffer, '3f 3f', 'point', 'normal'), (colours, '3f', 'color')],
            context.buffer(scene.triangles.tobytes()))
        self._frame = context.framebuffer(
            context.texture((camera.width, camera.height), 4),
            context.depth_renderbuffer((camera.width, camera.height)))
        self._rgb = np.empty((camera.height, camera.width, 3), np.uint8)

    def draw(self, points, normals):
        count = points.size // 3
        self._data[:count, :3], self._data[:count, 3:] = \
            points.reshape(-1, 3), normals.reshape(-1, 3)
        self._buffer.write(self._data[:count])
        self._frame.use()
        self._context.enable(self._context.DEPTH_TEST)
        self._frame.clear(*(BACKGROUND / 255.0))
        self._arrays.render()
        self._frame.read_into(self._rgb, components=3, alignment=1)
        return self._rgb[::-1]


class OpenCV:
    """OpenCV's triangleRasterize, of version 5; it lights nothing, so colours are given."""

    name = 'OpenCV triangleRasterize'

    def __init__(self, shot):
        import cv2
        self._rasterize = cv2.triangleRasterize
        camera, light, _, scene = self._shot = shot
        self._settings = cv2.TriangleRasterizeSettings().setCullingMode(
            cv2.RASTERIZE_CULLING_NONE).setShadingType(cv2.RASTERIZE_SHADING_SHADED)
        # OpenCV looks along -z, with y up.
        self._pose = np.diag([1.0, -1.0, -1.0, 1.0]) @ camera.pose
        self._points = scene.positions.astype(np.float32)
        self._colours = (shot.of_points('color') / 255).astype(np.float32)
        self._color = np.empty((camera.height, camera.width, 3), np.float32)
        self._depth = np.empty((camera.height, camera.width), np.float32)

    def draw(self, points, normals):
        camera, light, _, scene = self._shot
        count = points.size // 3
        self._points[:count] = points.reshape(-1, 3)
        cosine = normals.reshape(-1, 3) @ light.direction
        cosine /= np.sqrt(np.einsum('ijk,ijk->ij', normals, normals)).ravel()
        colours = self._colours.copy()
        colours[:count] *= (light.ambient + light.intensity * np.abs(cosine))[:, None]
        self._color[:] = BACKGROUND / 255.0
        self._depth[:] = 1000.0
        color, _ = self._rasterize(
            self._points, scene.triangles, colours, self._color, self._depth,
            self._pose, camera.vertical_fov, camera.near, 1000.0, self._settings)
        return np.minimum(color * 255.0, 255.0).astype(np.uint8)


class Tinydisplay:
    """Panda3D's software pipe; it lights only the side of the normals, here turned to the eye."""

    name = 'Panda3D tinydisplay'

    def __init__(self, shot):
        from panda3d import core
        core.load_prc_file_data('', 'load-display p3tinydisplay\nnotify-level fatal\n')
        camera, light, _, scene = self._shot = shot
        pipes = core.GraphicsPipeSelection.get_global_ptr()
        pipes.load_aux_modules()
        kinds = {kind.name: kind for kind in pipes.pipe_types}
        pipe = pipes.make_pipe(kinds['TinyOffscreenGraphicsPipe'])
        self._engine = core.GraphicsEngine.get_global_ptr()
        buffers = core.FrameBufferProperties()
        buffers.rgb_color, buffers.depth_bits = True, 24
        window = self._engine.make_output(
            pipe, 'picture', 0, buffers, core.WindowProperties(size=(camera.width, camera.height)),
            core.GraphicsPipe.BF_refuse_window)
        if window is None:
            raise RuntimeError('tinydisplay makes no buffer off the screen')
        self._texture = core.Texture()
        window.add_render_texture(self._texture, core.GraphicsOutput.RTM_copy_ram)
        window.set_clear_color((*(BACKGROUND / 255.0), 1.0))
        root = core.NodePath('root')
        lens = core.PerspectiveLens()
        fov = np.degrees(2 * np.arctan(0.5 * camera.width / camera.focal)), \
            np.degrees(camera.vertical_fov)
        lens.set_fov(*fov)
        lens.set_near_far(camera.near, 1000.0)
        eye = root.attach_new_node(core.Camera('eye', lens))
        eye.set_pos(*camera.position)
        eye.look_at(core.Point3(*camera.target), core.Vec3(0, 0, 1))
        window.make_display_region().set_camera(eye)
        for kind, level in ((core.DirectionalLight, light.intensity),
                            (core.AmbientLight, light.ambient)):
            lamp = kind('light')
            lamp.set_color((level, level, level, 1.0))
            if kind is core.DirectionalLight:
                lamp.set_direction(core.Vec3(*(-np.array(light.direction))))
            root.set_light(root.attach_new_node(lamp))
        root.set_two_sided(True)
        data = np.column_stack([scene.positions, scene.normals]).astype(np.float32)
        for number, (one, (points, triangles)) in enumerate(zip(shot.objects, scene.slices)):
            name = str(number)
            vertices = core.GeomVertexData(name, core.GeomVertexFormat.get_v3n3(),
                                           core.Geom.UH_dynamic)
            vertices.unclean_set_num_rows(int(points.stop - points.start))
            memoryview(vertices.modify_array(0)).cast('B')[:] = data[points].tobytes()
            numbers = core.GeomTriangles(core.Geom.UH_static)
            numbers.set_index_type(core.Geom.NT_uint32)
            table = scene.triangles[triangles] - points.start
            array = numbers.modify_vertices()
            array.unclean_set_num_rows(table.size)
            memoryview(array).cast('B')[:] = table.astype(np.uint32).tobytes()
            geom = core.Geom(vertices)
            geom.add_primitive(numbers)
            node = core.GeomNode(name)
            node.add_geom(geom)
            path = root.attach_new_node(node)
            matter = core.Material()
            color = (*(np.array(one.surface.color) / 255.0), 1.0)
            matter.set_ambient(color)
            matter.set_diffuse(color)
            path.set_material(matter)
            if number == 0:
                self._flag = node
        self._root, self._window = root, window
        self._data = data[scene.slices[0][0]]

    def draw(self, points, normals):
        self._data[:, :3], self._data[:, 3:] = points.reshape(-1, 3), -normals.reshape(-1, 3)
        vertices = self._flag.modify_geom(0).modify_vertex_data()
        memoryview(vertices.modify_array(0)).cast('B')[:] = self._data.reshape(-1).view(np.uint8)
        self._engine.render_frame()
        camera = self._shot.camera
        rgb = np.frombuffer(self._texture.get_ram_image_as('RGB'), np.uint8)
        return rgb.reshape(camera.height, camera.width, 3)[::-1]


PEERS = (Llvmpipe, Tinydisplay, Scanline, OpenCV)
