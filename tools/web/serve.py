#!/usr/bin/env python3
"""Serves folders over HTTP with range requests, to try the page: python3's own http.server has none.

  tools/web/serve.py [--port N] [--no-ranges] FOLDER...

Serves the page, tools/web/dist, and the files in the folders beside it: what is not in one is looked for in the next.
Prints the address and runs until it is stopped. For this machine only (127.0.0.1), and not made for more.
"""
import argparse
import http.server
import os
import re
import sys


class Handler(http.server.SimpleHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    extensions_map = {
        **http.server.SimpleHTTPRequestHandler.extensions_map,
        ".js": "text/javascript",
        ".wasm": "application/wasm",
        ".ptet": "application/octet-stream",
    }
    folders: list[str] = []
    has_ranges = True

    def translate_path(self, path):
        for folder in self.folders:
            self.directory = folder
            found = super().translate_path(path)
            if os.path.exists(found):
                break
        return found

    def send_head(self):
        wanted = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        path = self.translate_path(self.path)
        if not (self.has_ranges and wanted and os.path.isfile(path)):
            return super().send_head()
        size = os.path.getsize(path)
        begin = int(wanted[1])
        end = min(int(wanted[2]) + 1 if wanted[2] else size, size)
        if begin >= end:
            self.send_response(416)
            self.send_header("Content-Range", f"bytes */{size}")
            self.send_header("Content-Length", "0")
            self.end_headers()
            return None
        self.send_response(206)
        self.send_header("Content-Type", self.guess_type(path))
        self.send_header("Content-Range", f"bytes {begin}-{end - 1}/{size}")
        self.send_header("Content-Length", str(end - begin))
        self.send_header("Last-Modified", self.date_time_string(int(os.path.getmtime(path))))
        self.end_headers()
        self.left = end - begin
        file = open(path, "rb")
        file.seek(begin)
        return file

    def copyfile(self, source, outputfile):
        left = self.__dict__.pop("left", None)
        if left is None:
            super().copyfile(source, outputfile)
            return
        while left > 0 and (part := source.read(min(left, 1 << 16))):
            outputfile.write(part)
            left -= len(part)

    def end_headers(self):
        if self.has_ranges:
            self.send_header("Accept-Ranges", "bytes")
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()

    def log_message(self, *arguments):
        pass


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request, client_address):
        if not isinstance(sys.exc_info()[1], ConnectionError):  # a browser that wants no more of an answer
            super().handle_error(request, client_address)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=8000, help="0: any that is free (default: 8000)")
    parser.add_argument("--no-ranges", action="store_true", help="as a server without ranges does")
    parser.add_argument("folders", nargs="*", metavar="FOLDER", help="of .ptet files")
    arguments = parser.parse_args()
    page = os.path.join(os.path.dirname(os.path.abspath(__file__)), "dist")
    Handler.folders = [page, *map(os.path.abspath, arguments.folders)]
    Handler.has_ranges = not arguments.no_ranges
    with Server(("127.0.0.1", arguments.port), Handler) as server:
        print(f"http://127.0.0.1:{server.server_port}/", flush=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            pass


if __name__ == "__main__":
    main()
