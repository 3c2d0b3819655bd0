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

"""The default scene against programs by others: Embree's rays and Mesa's llvmpipe."""
import math

from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Texture
from flag_sim.drawing.scene import flag_scene
from flag_sim.drawing.scene_buffers import SceneBuffers
from flag_sim.drawing.shading import light_levels, shade

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

VIEWS = {
    'default': {},
    'wide': {'distance': 20.0, 'target': (0.5, 0.0, 5.0)},
    'behind': {'azimuth': 1.2, 'elevation': 0.3, 'distance': 7.0},
    'along the cloth': {'azimuth': 0.2, 'distance': 6.0},
    'platform': {'target': (0.0, 0.0, 0.2), 'distance': 2.5, 'elevation': 0.5},
    'below': {'target': (0.0, 0.0, 0.0), 'distance': 2.5, 'elevation': -1.2},
    'straight down': {'target': (0.7, 0.2, 5.0), 'distance': 8.0, 'elevation': math.pi / 2},
    'straight up': {'target': (0.7, 0.2, 5.0), 'distance': 8.0, 'elevation': -math.pi / 2},
    'rolled': {'roll': 0.7, 'elevation': 0.2, 'target': (0.3, 0.1, 8.8), 'distance': 1.5},
}


def assemble(camera):
    """Join flag, pole and platform as the picture does: the objects and their buffers."""
    objects = flag_scene(wave(), None, camera, Materials(), Dimensions())
    buffers = SceneBuffers(objects)
    for chunk in buffers.begin_frame(objects):
        buffers.load(chunk)
    return objects, buffers


def embree_depth(camera):
    """Cast a ray through the centre of every pixel: depth (height, width), inf for nothing."""
    scenes = pytest.importorskip('embreex.rtcore_scene', reason='embreex is not installed')
    from embreex.mesh_construction import TriangleMesh
    _, buffers = assemble(camera)
    # Embree's single precision is best near the camera.
    corners = (buffers.positions - camera.position) @ camera.pose[:3, :3].T
    scene = scenes.EmbreeScene()
    TriangleMesh(scene, corners[buffers.triangles].astype(np.float32))
    v, u = np.mgrid[:camera.height, :camera.width]
    ways = np.stack([(u - camera.centre[0]) / camera.focal,
                     (v - camera.centre[1]) / camera.focal, np.ones(u.shape)], axis=-1)
    ways = np.ascontiguousarray(ways.reshape(-1, 3), dtype=np.float32)
    hits = scene.run(np.zeros_like(ways), ways, output=1)
    depth = np.where(hits['primID'] >= 0, hits['tfar'], np.inf)
    return depth.reshape(camera.height, camera.width)


def rim(mask):
    """Find the pixels of a mask that have a neighbour of the other kind."""
    found = np.zeros_like(mask)
    across, down = mask[:, 1:] != mask[:, :-1], mask[1:] != mask[:-1]
    found[:, 1:] |= across
    found[:, :-1] |= across
    found[1:] |= down
    found[:-1] |= down
    return found


def test_mask_and_depth_against_embree():
    differing = silhouette = close = both = 0
    for view in VIEWS.values():
        camera, picture = Camera(**view), DepthPicture()
        picture.draw(wave(), camera=camera).colour
        depth, cast = picture.frame.depth, embree_depth(camera)
        drawn, hit = np.isfinite(depth), np.isfinite(cast)
        differing += np.sum(drawn != hit)
        silhouette += np.sum(rim(hit))
        shared = drawn & hit
        both += np.sum(shared)
        close += np.sum(np.abs(depth[shared] - cast[shared]) < 1e-4 * cast[shared])
    assert silhouette > 9 * 1000
    # Vertices are snapped to 1/256 pixel, so one silhouette pixel in a thousand may change.
    assert differing <= 0.001 * silhouette
    assert close >= 0.9999 * both


SHADER = """
#version 330
uniform vec2 size;
in vec3 screen;
in vec3 front;
in vec3 back;
{0} out vec3 front_color;
{0} out vec3 back_color;
void main() {{
    float w = 1.0 / screen.z;
    vec2 place = (screen.xy + 0.5) / size * 2.0 - 1.0;
    gl_Position = vec4(place.x * w, -place.y * w, (1.0 - screen.z) * w, w);
    front_color = front;
    back_color = back;
}}
"""
PIXELS = """
#version 330
{0} in vec3 front_color;
{0} in vec3 back_color;
out vec3 color;
void main() {{
    color = (gl_FrontFacing ? front_color : back_color) / 255.0;
}}
"""


def llvmpipe():
    """Return an OpenGL context of Mesa's own rasterizer, or skip the test."""
    gl = pytest.importorskip('moderngl', reason='moderngl is not installed')
    try:
        context = gl.create_context(standalone=True, backend='egl')
    except Exception as error:  # noqa: B902 (glcontext raises a bare Exception)
        pytest.skip(f'Mesa is not installed: {error}')
    if 'llvmpipe' not in context.info['GL_RENDERER']:
        pytest.skip(f'not llvmpipe: {context.info["GL_RENDERER"]}')
    return context


def on_screen(buffers, camera):
    """Return the vertices as shaders get them: (n, 3), places [pixel] and reversed Z."""
    points = buffers.positions @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    image = points @ camera.K.T
    # Snapped as by the picture; a corner's place is what both must agree on.
    places = np.floor(image[:, :2] / image[:, 2:] * 256 + 0.5) / 256
    return np.column_stack([places, 1.0 / points[:, 2]])


def llvmpipe_image(camera, light, interpolation, background):
    """Draw the same triangles with the same colours at their corners: (height, width, 3)."""
    context = llvmpipe()
    objects, buffers = assemble(camera)
    colours = np.empty((len(buffers.positions), 2, 3))
    for one, (vertices, _) in zip(objects, buffers.slices):
        shade(buffers.positions[vertices], buffers.normals[vertices], camera.viewpoint,
              one.surface, light, colours[vertices])
    data = np.column_stack([on_screen(buffers, camera), colours[:, 0], colours[:, 1]])
    word = '' if interpolation == 'perspective' else 'noperspective'
    program = context.program(vertex_shader=SHADER.format(word),
                              fragment_shader=PIXELS.format(word))
    program['size'] = camera.width, camera.height
    frame = context.simple_framebuffer((camera.width, camera.height), 3)
    frame.use()
    frame.clear(*(np.array(background) / 255.0), depth=1.0)
    vertices = context.buffer(data.astype(np.float32).tobytes())
    context.enable(context.DEPTH_TEST)
    # Closed bodies hide their backs; the flag shows both sides.
    for triangles, cull in ((buffers.triangles[buffers.is_closed == 0], False),
                            (buffers.triangles[buffers.is_closed == 1], True)):
        (context.enable if cull else context.disable)(context.CULL_FACE)
        numbers = context.buffer(np.ascontiguousarray(triangles).tobytes())
        context.vertex_array(program, [(vertices, '3f 3f 3f', 'screen', 'front', 'back')],
                             numbers).render()
    rows = np.frombuffer(frame.read(components=3), np.uint8)
    context.release()
    return rows.reshape(camera.height, camera.width, 3)[::-1]


# Rolled, the near plane cuts the pole; what is then linear on the screen is a matter of opinion.
@pytest.mark.parametrize('view, interpolation', [
    ('default', 'screen'), ('behind', 'screen'), ('along the cloth', 'screen'),
    ('default', 'perspective'), ('behind', 'perspective'), ('along the cloth', 'perspective'),
    ('rolled', 'perspective')])
def test_colour_against_llvmpipe(view, interpolation):
    camera, style = Camera(**VIEWS[view]), Style(interpolation=interpolation)
    expected = llvmpipe_image(camera, Light(), interpolation, style.background)
    rgb = DepthPicture().draw(wave(), camera=camera, style=style).colour
    apart = np.abs(rgb.astype(int) - expected).max(axis=-1)
    assert np.mean(np.any(expected != style.background, axis=-1)) > 0.05
    assert np.sum(apart > 1) == 0


TEXTURE_SHADER = """
#version 330
uniform vec2 size;
in vec3 screen;
in vec2 place;
in vec2 light;
out vec2 at;
noperspective out vec2 lit;
void main() {
    float w = 1.0 / screen.z;
    vec2 where = (screen.xy + 0.5) / size * 2.0 - 1.0;
    gl_Position = vec4(where.x * w, -where.y * w, (1.0 - screen.z) * w, w);
    at = place;
    lit = light;
}
"""
TEXTURE_PIXELS = """
#version 330
uniform sampler2D image;
uniform vec2 texels;
uniform float ambient;
in vec2 at;
noperspective in vec2 lit;
out vec3 color;
void main() {
    // As the specification of OpenGL has it: what llvmpipe takes by itself is coarser.
    vec2 across = dFdx(at) * texels, down = dFdy(at) * texels;
    float lod = 0.5 * log2(max(dot(across, across), dot(down, down)));
    vec3 light = textureLod(image, at, lod).rgb;
    vec3 encoded = mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055,
                       greaterThan(light, vec3(0.0031308)));
    color = encoded * (ambient + (gl_FrontFacing ? lit.x : lit.y));
}
"""


def llvmpipe_texture(camera, light, texture):
    """Draw the flag alone with the same mipmaps: (height, width, 3)."""
    context = llvmpipe()
    objects, buffers = assemble(camera)
    flag, (own, _) = objects[0], buffers.slices[0]
    sun, mirrored = np.empty((2, len(flag.vertices), 2, 3))
    light_levels(flag.vertices, buffers.normals[own], camera.viewpoint, flag.surface, light,
                 (sun, mirrored))
    data = np.column_stack([on_screen(buffers, camera)[own], flag.texture_coordinates,
                            sun[..., 0]]).astype(np.float32)
    program = context.program(vertex_shader=TEXTURE_SHADER, fragment_shader=TEXTURE_PIXELS)
    program['size'], program['texels'] = (camera.width, camera.height), texture.size
    program['ambient'] = light.ambient
    image = context.texture(texture.size, 4, dtype='f4')
    image.build_mipmaps()
    for level, (start, width, height) in enumerate(texture.levels):
        padded = texture.texels[4 * start:4 * (start + (width + 2) * (height + 2))]
        inner = padded.reshape(height + 2, width + 2, 4)[1:-1, 1:-1]
        image.write(np.ascontiguousarray(inner).tobytes(), level=level)
    image.filter = context.LINEAR_MIPMAP_LINEAR, context.LINEAR
    image.repeat_x = image.repeat_y = False
    image.use()
    frame = context.simple_framebuffer((camera.width, camera.height), 3)
    frame.use()
    frame.clear(depth=1.0)
    context.enable(context.DEPTH_TEST)
    context.vertex_array(
        program, [(context.buffer(data.tobytes()), '3f 2f 2f', 'screen', 'place', 'light')],
        context.buffer(np.ascontiguousarray(flag.triangles).tobytes())).render()
    rows = np.frombuffer(frame.read(components=3), np.uint8)
    context.release()
    return rows.reshape(camera.height, camera.width, 3)[::-1]


@pytest.mark.parametrize('view', ['default', 'wide', 'behind', 'near'])
def test_texture_against_llvmpipe(view):
    near = {'target': (1.5, 0.4, 8.1), 'distance': 1.5, 'roll': 0.5}
    camera = Camera(**VIEWS.get(view, near))
    v, u = np.mgrid[:300, :450]
    image = np.uint8(np.stack([255 * ((u // 30 + v // 30) % 2), 255 * u // 450,
                               127 + 120 * np.sin(0.05 * u + 0.11 * v)], axis=-1))
    expected = llvmpipe_texture(camera, Light(), Texture(image))
    frame = Picture().draw(wave(), camera=camera, channels=['visibility'],
                           dimensions=Dimensions(pole_visible=False, platform_visible=False),
                           materials=Materials(flag_image=Texture(image)))
    seen = frame.visibility.triangles >= 0
    apart = np.abs(frame.colour.astype(int) - expected).max(axis=-1)[seen]
    assert seen.sum() > 3000
    assert apart.mean() < 0.3
    # Derivatives of OpenGL are differences within 2 x 2 pixels, also across edges.
    assert np.mean(apart > 2) < 0.001
