# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

"""blender --background --factory-startup --python quality_blender.py -- PICTURE.exr MAP.exr LARGEST OUT.exr

The Defocus node with a blur map: radius = map (0 to 1) times half of LARGEST, the largest CoC in pixels. Without Z it
knows no order of depth; all other settings are those of a new node but preview, threshold and the gamma correction.
"""
import os
import sys

import bpy

picture, blur, largest, out = sys.argv[sys.argv.index("--") + 1:]
scene = bpy.context.scene
scene.use_nodes = True
nodes, links = scene.node_tree.nodes, scene.node_tree.links
nodes.clear()


def image_node(path):
    node = nodes.new("CompositorNodeImage")
    node.image = bpy.data.images.load(os.path.abspath(path))
    node.image.colorspace_settings.name = "Non-Color"
    return node


source, map_node = image_node(picture), image_node(blur)
defocus = nodes.new("CompositorNodeDefocus")
defocus.bokeh = "CIRCLE"
defocus.use_zbuffer = False
defocus.z_scale = defocus.blur_max = float(largest) / 2
defocus.use_preview = False
defocus.use_gamma_correction = False
defocus.threshold = 0
result = nodes.new("CompositorNodeComposite")
result.use_alpha = False
links.new(source.outputs["Image"], defocus.inputs["Image"])
links.new(map_node.outputs["Image"], defocus.inputs["Z"])
links.new(defocus.outputs["Image"], result.inputs["Image"])

render = scene.render
render.resolution_x, render.resolution_y = source.image.size
render.resolution_percentage = 100
render.use_sequencer = False
scene.view_settings.view_transform = "Raw"
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
render.filepath = os.path.abspath(out)
bpy.ops.render.render(write_still=True)
