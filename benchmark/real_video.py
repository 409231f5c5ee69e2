"""Both trackers of video on real video: ``python benchmark/real_video.py FOLDER``.

Prints the table of real_windows.py where FOLDER holds sequences of one target, those of
real_contours.py where it holds clips of all that moves; what such are is written there. Folders of
both kinds may lie beside each other.
"""

import cv2
import real_contours
import real_windows


def main() -> None:
    given = real_windows.parser_of(__doc__).parse_args()
    cv2.setNumThreads(1)
    folders = real_windows.folders_of(given.folder)
    clips = real_contours.clips_of(given.folder)
    if not folders and not clips:
        raise SystemExit(
            f'{given.folder}: expected folders with a groundtruth*.txt, folders with a seqinfo.ini '
            'and a gt, or videos NAME.mp4 with a NAME.frames, found none'
        )
    if folders:
        real_windows.table(folders, given)
    if clips:
        real_contours.table(clips, real_contours.IOU, given.only)


if __name__ == '__main__':
    main()
