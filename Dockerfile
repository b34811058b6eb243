# JupyterLab with the course, from the same locked packages as everywhere else.
#
#   docker build -t ekfslam .
#   docker run --rm -p 127.0.0.1:8888:8888 ekfslam      # then open the address it prints, with its token
#
# What you write is gone with the container; to keep it: -v "$PWD/mycourse:/home/student/mycourse"
FROM python:3.12-slim

RUN apt-get update && apt-get install -y --no-install-recommends git make && rm -rf /var/lib/apt/lists/*
RUN useradd --create-home --uid 1000 student
WORKDIR /home/student/ekfslam_tutorial

# The packages first: this layer is built anew only when the lock changes.
COPY requirements.txt .
RUN python -m pip install --no-cache-dir --require-hashes --only-binary=:all: -r requirements.txt
COPY . .
RUN python -m pip install --no-cache-dir --no-deps --no-build-isolation -e . && chown -R student:student .

USER student
EXPOSE 8888
# 0.0.0.0 is the container's own address, reached only through -p; the token stays.
CMD ["jupyter", "lab", "--ip=0.0.0.0", "--no-browser", "--notebook-dir=notebooks"]
