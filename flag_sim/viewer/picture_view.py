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

"""The picture: the bytes of the latest image on the screen, at their own aspect, and a reason."""
from flag_sim.parameters.checks import shown
from flag_sim.protocol.cdr_image import ImageBytes
from qtpy.QtCore import QRect, QSize, Qt, Signal
from qtpy.QtGui import QColor, QImage, QPainter
from qtpy.QtWidgets import QSizePolicy, QWidget

FORMATS = {
    'rgb8': (QImage.Format_RGB888, 3), 'bgr8': (QImage.Format_RGB888, 3),
    'rgba8': (QImage.Format_RGBA8888, 4), 'bgra8': (QImage.Format_ARGB32, 4),
    'mono8': (QImage.Format_Grayscale8, 1), '8UC1': (QImage.Format_Grayscale8, 1),
    '8UC3': (QImage.Format_RGB888, 3),
}
"""Qt's format and the bytes of a pixel, by the encoding of a sensor_msgs/Image."""


def to_image(picture: ImageBytes) -> tuple[QImage | None, str]:
    """Return (the image, '') or (None, why it cannot be shown). It owns its pixels."""
    if picture.encoding not in FORMATS:
        return None, (f'The images are of the encoding {shown(picture.encoding)}; shown here are '
                      f'{", ".join(FORMATS)}.')
    kind, size = FORMATS[picture.encoding]
    if not picture.width or not picture.height:
        return None, f'The images have no pixels: {picture.width} x {picture.height}.'
    if picture.step < picture.width * size:
        return None, (f'The images have rows of {picture.step} bytes, too few for {picture.width} '
                      f'pixels of {picture.encoding}.')
    pixels, step = bytes(picture.pixels), picture.step
    if step % size and size == 4:  # Qt reads such pixels as whole words
        pixels, step = b''.join(pixels[row:row + picture.width * size] for row in range(
            0, len(pixels), step)), picture.width * size
    image = QImage(pixels, picture.width, picture.height, step, kind)
    # 32 bits a pixel is what Qt draws fastest, and a copy that needs no foreign bytes.
    image = image.convertToFormat(QImage.Format_RGB32)
    return (image.rgbSwapped() if picture.encoding == 'bgr8' else image), ''


class PictureView(QWidget):
    """
    Shows an image as large as it fits, and over it why it stands still.

    wheel, dragged, keyed and double_clicked tell what hands do on it: steps away from the user;
    logical pixels (right, down) with the right button; parts of the height (right, up).
    """

    wheel = Signal(float)
    dragged = Signal(float, float)
    drag_ended = Signal()
    keyed = Signal(float, float)
    double_clicked = Signal()

    KEYS = {Qt.Key_W: (0, 1), Qt.Key_S: (0, -1), Qt.Key_A: (-1, 0), Qt.Key_D: (1, 0)}

    def __init__(self):
        super().__init__()
        self.image = None
        self.reason = ''
        self._grip = None  # where the right button was pressed, or moved to
        self.setFocusPolicy(Qt.StrongFocus)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)
        self.setMinimumSize(160, 120)
        self.setAccessibleName('picture')
        self.setToolTip('W A S D: shift; wheel: nearer, farther; drag with the right button: '
                        'turn;\ndouble click or Home: as it was at first')
        self.setAttribute(Qt.WA_OpaquePaintEvent)

    def sizeHint(self) -> QSize:
        """Return the size of the image, or of a usual one."""
        return self.image.size() if self.image is not None else QSize(640, 480)

    def show_image(self, image: QImage) -> None:
        """Show an image instead of the one before."""
        if self.image is None or image.size() != self.image.size():
            self.updateGeometry()
        self.image = image
        self.update()

    def set_reason(self, reason: str) -> None:
        """Say why the picture stands still; '' where it does not."""
        if reason != self.reason:
            self.reason = reason
            self.setAccessibleDescription(reason)
            self.update()

    def target(self) -> QRect:
        """Return where the image is drawn, in pixels of the screen."""
        ratio = self.devicePixelRatioF()
        width, height = round(self.width() * ratio), round(self.height() * ratio)
        if self.image is None:
            return QRect(0, 0, width, height)
        scale = min(width / self.image.width(), height / self.image.height())
        # Whole numbers of screen pixels a pixel, where that nearly fills the view: they are sharp.
        if scale >= 1.0 and scale - int(scale) < 0.1:
            scale = int(scale)
        size = (max(round(self.image.width() * scale), 1),
                max(round(self.image.height() * scale), 1))
        return QRect((width - size[0]) // 2, (height - size[1]) // 2, *size)

    def paintEvent(self, _) -> None:
        """Draw the image, what is beside it, and the reason."""
        painter = QPainter(self)
        ratio = self.devicePixelRatioF()
        target = self.target()
        painter.save()
        painter.scale(1.0 / ratio, 1.0 / ratio)
        if self.image is not None:
            is_whole = target.width() % self.image.width() == 0
            painter.setRenderHint(QPainter.SmoothPixmapTransform, not is_whole)
            painter.drawImage(target, self.image)
        full = QRect(0, 0, round(self.width() * ratio) + 1, round(self.height() * ratio) + 1)
        beside = self.palette().mid()
        if self.image is None:
            painter.fillRect(full, beside)
        else:
            painter.fillRect(QRect(0, 0, full.width(), target.top()), beside)
            painter.fillRect(QRect(0, target.bottom() + 1, full.width(), full.height()), beside)
            painter.fillRect(QRect(0, target.top(), target.left(), target.height()), beside)
            painter.fillRect(QRect(target.right() + 1, target.top(), full.width(),
                                   target.height()), beside)
        painter.restore()
        if self.reason:
            self._paint_reason(painter)
        if self.hasFocus():
            painter.setPen(self.palette().highlight().color())
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _paint_reason(self, painter):
        flags = Qt.AlignCenter | Qt.TextWordWrap
        room = self.rect().adjusted(24, 24, -24, -24)
        box = painter.boundingRect(room, flags, self.reason).adjusted(-12, -8, 12, 8)
        if self.image is not None:  # the last picture stays visible
            box.moveBottom(self.height() - 12)
        back = QColor(self.palette().window().color())
        back.setAlpha(225)
        painter.fillRect(box, back)
        painter.setPen(self.palette().windowText().color())
        painter.drawText(box, flags, self.reason)

    # Hands.

    def wheelEvent(self, event) -> None:
        """Tell of the wheel."""
        self.wheel.emit(event.angleDelta().y() / 120.0)
        event.accept()

    def mousePressEvent(self, event) -> None:
        """Take hold with the right button."""
        if event.button() == Qt.RightButton:
            self._grip = event.position()

    def mouseMoveEvent(self, event) -> None:
        """Tell how far a drag went since it was told last."""
        if self._grip is not None:
            moved, self._grip = event.position() - self._grip, event.position()
            self.dragged.emit(moved.x(), moved.y())

    def mouseReleaseEvent(self, event) -> None:
        """Let go."""
        if event.button() == Qt.RightButton and self._grip is not None:
            self._grip = None
            self.drag_ended.emit()

    def mouseDoubleClickEvent(self, event) -> None:
        """Tell of a double click with the left button."""
        if event.button() == Qt.LeftButton:
            self.double_clicked.emit()

    def keyPressEvent(self, event) -> None:
        """Tell of W, A, S, D and of what keys do in place of the mouse."""
        key, turns = event.key(), event.modifiers() & Qt.ShiftModifier
        arrows = {Qt.Key_Left: (-20, 0), Qt.Key_Right: (20, 0),
                  Qt.Key_Up: (0, -20), Qt.Key_Down: (0, 20)}
        if key in self.KEYS and not event.modifiers() & ~Qt.ShiftModifier:
            self.keyed.emit(*map(float, self.KEYS[key]))
        elif key in arrows and turns:
            self.dragged.emit(*map(float, arrows[key]))
        elif key in (Qt.Key_Plus, Qt.Key_Minus, Qt.Key_Equal):
            self.wheel.emit(-1.0 if key == Qt.Key_Minus else 1.0)
        elif key == Qt.Key_Home:
            self.double_clicked.emit()
        else:
            super().keyPressEvent(event)
